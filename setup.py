"""Install the package, with pip or as ament_python with colcon."""

import re
import runpy
import sys
from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'mobile_robot_control'
REPOSITORY = 'https://github.com/mobile-robot-control/mobile_robot_control'
"""A placeholder, until the maintainers have one."""


def long_description():
    """Return the README, with links that lead to the repository from elsewhere."""
    text = Path('README.md').read_text(encoding='utf-8')
    text = re.sub(r'!\[([^]]*)\]\((?!https?:)', rf'![\1]({REPOSITORY}/raw/main/', text)
    return re.sub(r'\]\((?!https?:|#)', f']({REPOSITORY}/blob/main/', text)


def executables():
    """List `mrc`, and for `ros2 run` every name, which pip, building by a backend, would put on everybody's PATH."""
    names = runpy.run_path(f'{PACKAGE}/__main__.py')
    found = [f'mrc = {PACKAGE}.__main__:main']
    if 'setuptools.build_meta' not in sys.modules:
        found += [f'{name} = {PACKAGE}.__main__:main' for name in (*names['NODES'], *names['COMMANDS'])]
    return found


def config_files():
    """List the files for nodes and desktop tools by the folder that they are installed to."""
    files = [path for path in Path('config').rglob('*') if path.suffix in ('.yaml', '.csv', '.urdf', '.rviz', '.xml')]
    folders = sorted({path.parent for path in files})
    return [(f'share/{PACKAGE}/{folder}', sorted(str(path) for path in files if path.parent == folder))
            for folder in folders]


setup(
    name=PACKAGE,
    version=runpy.run_path(f'{PACKAGE}/version.py')['__version__'],
    description='Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2.',
    long_description=long_description(),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    license_files=['LICENSE', 'mobile_robot_control/web/uplot/LICENSE'],
    url=REPOSITORY,
    project_urls={'Documentation': f'{REPOSITORY}/blob/main/docs/index.md', 'Issues': f'{REPOSITORY}/issues',
                  'Changelog': f'{REPOSITORY}/blob/main/CHANGELOG.rst'},
    keywords=['control', 'differential drive', 'mobile robot', 'ros2', 'trajectory tracking'],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Education',
        'Intended Audience :: Science/Research',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3',
        *(f'Programming Language :: Python :: 3.{minor}' for minor in (10, 11, 12)),
        'Topic :: Scientific/Engineering',
        'Typing :: Typed',
    ],
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
        'fast': ['numba>=0.58', 'scipy>=1.11'],
        # rollouts on an NVIDIA GPU, with the compiler
        'cuda': ['numba-cuda[cu12]>=0.30,<1', 'numba>=0.62', 'numpy<2.5', 'scipy>=1.11'],
        # the page to watch and handle the robot
        'dashboard': ['starlette>=0.31', 'uvicorn>=0.27', 'websockets>=10.4'],
        # the search on a cluster
        'cluster': ['distributed>=2024.1'],
        # the robots of examples/mujoco
        'mujoco': ['mujoco>=3.3,<4'],
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
        'console_scripts': executables(),
    },
)
