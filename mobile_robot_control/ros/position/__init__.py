"""The node `position_controller`, its guard, stops, and the judgement of odometry."""
