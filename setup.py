"""Install the package, with pip or as ament_python with colcon."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'mobile_robot_control'
NODES = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
COMMANDS = {
    'simulate': 'runs', 'experiment': 'experiment', 'report': 'report', 'tune': 'search', 'study': 'studying',
    'benchmark': 'benchmarking', 'plan': 'planning', 'excite': 'excitation', 'identify': 'identification',
    'dashboard': 'dashboard',
}
"""The folder of each command, whose `command.py` has its `main`."""


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
    package_data={PACKAGE: ['py.typed', '__init__.pyi', 'ros/start/*.xml', 'web/*.js', 'web/*.css', 'web/uplot/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/launch', sorted(map(str, Path('launch').iterdir()))),
        *config_files(),
    ],
    # the oldest versions are those of Ubuntu 24.04; those that the tests run with are locked in constraints/
    install_requires=['setuptools', 'PyYAML>=6.0.1', 'matplotlib>=3.6', 'mcap>=1.1', 'numpy>=1.26', 'pillow>=10.2',
                      'rosbags>=0.11', 'tqdm>=4.66'],
    extras_require={
        # ROS 2 itself, for a machine without one: one distribution an environment; an installed ROS 2 needs neither
        'jazzy': ['ros-jazzy-rclpy', 'ros-jazzy-common-interfaces', 'ros-jazzy-rmw-fastrtps-cpp'],
        'kilted': ['ros-kilted-rclpy', 'ros-kilted-common-interfaces', 'ros-kilted-rmw-fastrtps-cpp'],
        # compiled rollouts: some hundred times faster searches; and what identify fits with
        'fast': ['numba>=0.62', 'scipy>=1.11'],
        # rollouts on an NVIDIA GPU, with the compiler
        'cuda': ['numba-cuda[cu12]>=0.30,<1', 'numba>=0.62', 'numpy<2.5', 'scipy>=1.11'],
        # the page to watch and handle the robot
        'dashboard': ['starlette>=0.31', 'uvicorn>=0.27', 'websockets>=10.4'],
        # the search on a cluster
        'cluster': ['distributed>=2024.1'],
        # the files in constraints/: make constraints
        'locking': ['uv'],
        # the documentation as a site: make docs
        'docs': ['furo', 'myst-parser>=4', 'numpydoc>=1.8', 'sphinx>=8'],
        'mutants': ['cosmic-ray>=8.4', 'coverage', 'pytest-cov'],
        'test': [
            # of pages, for everybody; it has axe-core 4.4 and needs nothing
            'axe-core-python',
            'colcon-core',
            'colcon-package-information',
            'colcon-ros',
            'hypothesis',
            # of the notebook in examples
            'ipykernel',
            'mcap-ros2-support',
            # what elementary functions are compared with
            'mpmath',
            'mypy',
            'nbclient',
            'pandas',
            # a solver, with which model predictive control is compared
            'piqp',
            'pytest>=8',
            'pytest-timeout',
            'pytest-xdist',
            # what a law of this package is compared with
            'robotpy-wpimath',
            'toppra',
            'ruff',
            'selenium',
            'types-PyYAML',
            'wheel',
        ],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            *(f'{node} = {PACKAGE}.ros.start.executables:{node}' for node in NODES),
            *(f'{command} = {PACKAGE}.{folder}.command:main' for command, folder in COMMANDS.items()),
        ],
    },
)
