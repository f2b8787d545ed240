"""Install the package, with pip or as ament_python with colcon."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'mobile_robot_control'
NODES = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
COMMANDS = {
    'simulate': 'runs.simulation', 'experiment': 'experiment.command', 'report': 'report.reports',
    'tune': 'search.command', 'study': 'studying.command', 'benchmark': 'benchmarking.command',
    'plan': 'planning.command', 'excite': 'experiment.excite', 'identify': 'identification.command',
    'dashboard': 'dashboard.serving',
}
"""The module of each command."""


def config_files():
    """List the files for nodes and desktop tools by the folder that they are installed to."""
    files = [path for path in Path('config').rglob('*') if path.suffix in ('.yaml', '.csv', '.urdf', '.rviz', '.xml')]
    folders = sorted({path.parent for path in files})
    return [(f'share/{PACKAGE}/{folder}', sorted(str(path) for path in files if path.parent == folder))
            for folder in folders]


setup(
    name=PACKAGE,
    version='0.1.0',
    description='Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2.',
    license='Apache-2.0',
    maintainer='mobile_robot_control maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    python_requires='>=3.10',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    # the annotations are for users, too; scripts and styles of pages
    package_data={PACKAGE: ['py.typed', '__init__.pyi', 'ros/*.xml', 'web/*.js', 'web/*.css', 'web/uplot/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        *config_files(),
    ],
    install_requires=['setuptools', 'PyYAML', 'matplotlib', 'mcap', 'numpy', 'pillow', 'rosbags', 'tqdm'],
    extras_require={
        # ROS 2 itself, for a machine without one: one distribution an environment; an installed ROS 2 needs neither
        'kilted': [
            'ros-kilted-rclpy==9.1.2',
            'ros-kilted-common-interfaces==5.5.1',
            'ros-kilted-rmw-fastrtps-cpp==9.3.3',
        ],
        'jazzy': [
            'ros-jazzy-rclpy==7.1.6',
            'ros-jazzy-common-interfaces==5.3.6',
            'ros-jazzy-rmw-fastrtps-cpp==8.4.3',
        ],
        # compiled rollouts: some hundred times faster searches; and the second algorithm
        'fast': ['numba==0.68.0', 'scipy==1.15.3'],
        # the page to watch and handle the robot
        'dashboard': ['starlette==1.7.0', 'uvicorn==0.54.0', 'websockets==16.1.1'],
        # the search on a cluster
        'cluster': ['distributed==2026.8.0'],
        # the versions that the tests run with
        'pinned': [
            'PyYAML==6.0.3',
            'matplotlib==3.10.9',
            'mcap==1.6.0',
            'numpy==2.2.6',
            'pillow==12.0.0',
            'rosbags==0.11.9',
            'tqdm==4.70.1',
        ],
        # the files in constraints/: make constraints
        'locking': ['uv==0.13.9'],
        # the documentation as a site: make docs
        'docs': [
            'furo==2025.12.19',
            'myst-parser==4.0.1',
            'numpydoc==1.11.0',
            'sphinx==8.1.3',
        ],
        'mutants': [
            'cosmic-ray==8.7.0',
            'coverage==7.10.7',
            'pytest-cov==7.1.0',
        ],
        'test': [
            # of pages, for everybody; it has axe-core 4.4 and needs nothing
            'axe-core-python==0.1.0',
            'colcon-core==0.21.3',
            'colcon-package-information==0.4.1',
            'colcon-ros==0.5.0',
            'hypothesis==6.168.5',
            # of the notebook in examples
            'ipykernel==6.30.1',
            'mcap-ros2-support==0.6.0',
            'mypy==2.4.1',
            'nbclient==0.11.0',
            'pandas==2.3.3',
            # of examples/mpc_controller
            'piqp==0.7.0',
            'pytest==9.2.0',
            'pytest-timeout==2.4.0',
            'pytest-xdist==3.8.0',
            # what a law of this package is compared with
            'robotpy-wpimath==2026.2.2',
            'toppra==0.6.10',
            'ruff==0.17.5',
            'selenium==4.51.0',
            'types-PyYAML==6.0.12.20261113',
            'wheel==0.45.1',
        ],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            *(f'{node} = {PACKAGE}.ros.executables:{node}' for node in NODES),
            *(f'{command} = {PACKAGE}.{module}:main' for command, module in COMMANDS.items()),
        ],
    },
)
