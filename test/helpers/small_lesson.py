"""A lesson of one control and one number."""

LESSON = {
    'title': 'A lesson', 'text': 'Words.', 'question': 'How far?', 'robots': ['chapter'], 'show': ['e1'],
    'start': {'parameters': {'plant': {'max_wheel_torque': 0.3}}, 'pose': [0.0, -0.3, 0.0]},
    'controls': [{'label': 'gain', 'sets': ['position_controller.backstepping.p'], 'range': [1.0, 2.0, 0.1]}],
    'answer': {'kind': 'number', 'measure': 'mean', 'of': ['e1'], 'over': 5.0, 'unit': 'm', 'tolerance': 0.1},
}
