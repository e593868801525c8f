"""Each process that runs tests has its own ROS domain and stays on this machine."""

import os
import signal

from hypothesis import HealthCheck, settings

# A shell starts what runs in the background deaf to Ctrl-C, and children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)

# The same draws each time, however slow the machine is at that moment.  Others: with
# --hypothesis-profile=others --hypothesis-seed=N.
patient = settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
settings.register_profile('others', patient, print_blob=True)
settings.register_profile('same', patient, derandomize=True)
settings.load_profile('same')
