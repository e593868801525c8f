"""The pages: frames a second of a report drawn in software, and what an open page costs a node."""

import select
import subprocess
import tempfile
import time
from pathlib import Path

import in_browser
from common import ARGUMENTS, QUICK, Claim, medians, show
from live import SUBSCRIBER, cpu_of_a_tick, node, start, stop

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.report.html import report
from satdyn_ros.run.scenario import Scenario

PLAYED_S, FRAMES_PER_S = 2.0 if QUICK else 20.0, 30.0
BAG_S = 100.0 if QUICK else 10000.0
PORT = 8099

# A browser on another machine: it takes every frame and draws none here.
BROWSER = f"""
import asyncio
import aiohttp
async def watch():
    async with aiohttp.ClientSession() as session:
        while True:
            try:
                url = 'http://127.0.0.1:{PORT}/socket'
                async with session.ws_connect(url, max_msg_size=0) as socket:
                    async for message in socket:
                        pass
            except aiohttp.ClientError:
                await asyncio.sleep(0.2)
asyncio.run(watch())
"""


def million_messages(directory: Path) -> Path:
    """Return the report of a bag of a million messages."""
    scenario = Scenario.from_dict(
        {
            'publish': {'rate': 50.0, 'topics': ['attitude', 'imu']},
            'time': {'epoch_ns': 10**18},
            'rotor': {'mode': 'free', 'inertia': 0.5, 'speed': 30.0},
        }
    )
    for _ in simulate(scenario, BAG_S, directory / 'bag'):
        pass
    report(directory / 'bag', directory / 'report.html')
    return directory / 'report.html'


def frames_per_second(page: Path) -> tuple[float, float]:
    """Play a page in software; return the frames a second it measures, and its sharpness."""
    with in_browser.chromium() as chromium:
        chromium.get(page.as_uri())
        chromium.execute_script('satdyn.timeline.play(true)')
        # A slow machine draws fewer pixels until it keeps pace.
        time.sleep(PLAYED_S)
        scene = 'satdyn.stage.scene'
        return tuple(
            chromium.execute_script(f'return [{scene}.framesPerSecond, {scene}.sharpness]')
        )


def node_cpu(directory: Path, watchers: list[list[str]]) -> float:
    """Return the CPU time of a tick [us] of a node beside those that watch it."""
    watching = [start(arguments, stdout=subprocess.PIPE) for arguments in watchers]
    try:
        if QUICK and in_browser.__file__ in watchers[-1]:
            # All would be over before Chromium shows anything.
            shown, _, _ = select.select([watching[-1].stdout], [], [], 60.0)
            if not shown:
                raise RuntimeError('Chromium shows no page of satdyn watch')
        return cpu_of_a_tick(lambda: node(directory, record=False))
    finally:
        for process in watching:
            stop(process)


def main(rounds: int = 5) -> tuple[str, list[Claim], str]:
    """Run all; return title, claims and text."""
    claims = []
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        page = million_messages(directory)
        text = f'The report of a million messages has {page.stat().st_size / 1e6:.1f} MB. '
        if in_browser.is_there():
            rate, sharpness = frames_per_second(page)
            claims.append(
                Claim(
                    'frames a second of a report of a million messages, drawn in software',
                    f'{rate:.0f}',
                    f'{FRAMES_PER_S:.0f} asked for',
                    rate / FRAMES_PER_S,
                    must=1.0,
                )
            )
            text += f'The scene was drawn with {sharpness:.0%} of the pixels in each direction. '
        else:
            text += 'No chromium is installed to play it. '
        watch = ['-m', 'satdyn_ros.cli.main', 'watch', '--port', str(PORT)]
        contenders = {
            'subscriber': lambda: node_cpu(directory, [['-c', SUBSCRIBER]]),
            'drawing none': lambda: node_cpu(directory, [watch, ['-c', BROWSER]]),
        }
        if in_browser.is_there():
            show_page = [in_browser.__file__, f'http://127.0.0.1:{PORT}/']
            contenders['in Chromium'] = lambda: node_cpu(directory, [watch, show_page])
        subscribed, *watched = medians(contenders, rounds).values()
    for kind, used in zip(list(contenders)[1:], watched, strict=True):
        claims.append(
            Claim(
                f'CPU of a tick at 1000 Hz with a page ({kind}) over that with a subscriber',
                f'{used:.0f} us',
                f'{subscribed:.0f} us',
                used / subscribed,
                must=1.05,
                at_most=True,
            )
        )
    text += (
        'A page drawing none is one on another machine, which takes every frame; Chromium draws '
        'the scene in software beside the node, on the same processors.'
    )
    show(claims)
    print(text)
    return 'The pages', claims, text


if __name__ == '__main__':
    main(*map(int, ARGUMENTS))
