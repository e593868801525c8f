"""
Satellites to train on: environments of Gymnasium, one alone or many in step.

    env = gymnasium.make('satdyn_ros.gym:satdyn/Detumble-v0')
    envs = gymnasium.make_vec('satdyn_ros.gym:satdyn/Detumble-v0', num_envs=1024)

Task: what an episode of one's own is, for SatelliteEnv(task) and SatelliteVectorEnv(task, 1024).
"""

try:
    from gymnasium import register
except ImportError:
    raise ImportError(
        'satdyn_ros.gym needs gymnasium: pip install gymnasium', name='gymnasium'
    ) from None

from .satellite_env import SatelliteEnv
from .satellite_vector_env import SatelliteVectorEnv
from .task import Task
from .tasks import TASKS

for _name in TASKS:
    register(
        id=f'satdyn/{_name}-v0',
        entry_point=f'{__name__}.satellite_env:SatelliteEnv',
        vector_entry_point=f'{__name__}.satellite_vector_env:SatelliteVectorEnv',
        kwargs={'task': _name},
    )

__all__ = ['SatelliteEnv', 'SatelliteVectorEnv', 'Task']
