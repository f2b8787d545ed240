"""The columns of each topic of a run, and the conversion of its messages to them."""

from mobile_robot_control.messages.topic_forms import columns_reader
from mobile_robot_control.topics import RUN_TOPICS

TRUE_ERROR = 'true_error'
COLUMNS = {**{name: topic.columns for name, topic in RUN_TOPICS.items()},
           TRUE_ERROR: RUN_TOPICS['tracking_error'].columns}
"""The topics of a run; and the true error, if it differs from `tracking_error`, which no topic carries."""
READ = {topic: columns_reader(topic) for topic in RUN_TOPICS}
"""Reads a message of each topic into its COLUMNS."""
