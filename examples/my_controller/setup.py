"""Install the law, with pip or as ament_python with colcon."""

from setuptools import setup

PACKAGE = 'my_controller'

setup(
    name=PACKAGE,
    version='0.1.0',
    description='A position law for mobile_robot_control: that of Kanayama et al.',
    license='Apache-2.0',
    maintainer='mobile_robot_control maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    python_requires='>=3.10',
    packages=[PACKAGE],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/config', ['config/kanayama.yaml']),
    ],
    install_requires=['setuptools', 'mobile_robot_control'],
    zip_safe=False,
    entry_points={'mobile_robot_control.laws': [f'my_kanayama = {PACKAGE}.kanayama:LAW']},
)
