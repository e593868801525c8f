"""Run every benchmark and write RESULTS.md; with --quick, only see that each runs."""

import importlib
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from common import ARGUMENTS, HEADER, QUICK

HERE = Path(__file__).parent
SCRIPTS = (
    'propagation',
    'step',
    'processors',
    'rotors',
    'moving_parts',
    'closed_forms',
    'batch',
    'sweep',
    'loop',
    'learning',
    'offline',
    'export',
    'live',
    'environment',
    'beside_basilisk',
    'fleet',
    'page',
    'start',
)
PACKAGES = (
    'numpy',
    'scipy',
    'numba',
    'mcap',
    'ros-jazzy-rclpy',
    'heyoka',
    'bsk',
    'foxglove-sdk',
)


def main():
    """Run the scripts that are here, in turn, and write the results as they come."""
    chosen = ARGUMENTS or [name for name in SCRIPTS if (HERE / f'{name}.py').exists()]
    parts = [_machine()]
    for name in chosen:
        title, claims, text = importlib.import_module(name).main()
        rows = '\n'.join(claim.row() for claim in claims)
        parts.append(f'## {title}\n\n`python benchmark/{name}.py`\n\n{HEADER}\n{rows}\n\n{text}')
        if not QUICK:
            (HERE / 'RESULTS.md').write_text('\n\n'.join(part.strip() for part in parts) + '\n')


def _machine():
    lscpu = subprocess.run(['lscpu'], stdout=subprocess.PIPE, text=True, check=False).stdout
    # On a virtual machine the name does not say how wide the vectors are; the model does.
    named = 'CPU(s):', 'Model name:', 'CPU family:', 'Model:'
    lines = [line for line in lscpu.splitlines() if line.strip().startswith(named)]
    facts = [' '.join(line.split()) for line in lines]
    facts.append(f'Python {platform.python_version()}, {platform.system()}')
    for package in PACKAGES:
        try:
            facts.append(f'{package} {version(package)}')
        except PackageNotFoundError:
            continue
    return (
        '# Results\n\nWritten by `make bench`: CPU time ratios, medians of interleaved rounds in '
        'one process tree.\nNo figure without its peer.\n\n' + '\n'.join(f'- {f}' for f in facts)
    )


if __name__ == '__main__':
    main()
