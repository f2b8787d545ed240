"""Install the node, with pip or as ament_python with colcon."""

from setuptools import setup

PACKAGE = 'command_filter'

setup(
    name=PACKAGE,
    version='0.1.0',
    description='A node for mobile_robot_control: a low-pass filter of its commands.',
    license='Apache-2.0',
    maintainer='mobile_robot_control maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    python_requires='>=3.10',
    packages=[PACKAGE],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
    ],
    install_requires=['setuptools', 'mobile_robot_control'],
    zip_safe=False,
    entry_points={'console_scripts': [f'command_filter = {PACKAGE}.node:main']},
)
