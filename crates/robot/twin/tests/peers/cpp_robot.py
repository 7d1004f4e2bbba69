"""A robot on the vendor's C++ SDK that stands still: says that no controller is in command and its state, and reports the commands it hears.

cpp_robot.py DOMAIN
"""

import sys
import time

import cpp_wire
import unitree_interface as sdk

JOINTS = 29
robot = cpp_wire.open_g1(int(sys.argv[1]))
robot.enable_motion_switcher_responder()
state = sdk.LowState(JOINTS)
state.mode_machine = 5
state.imu.quat = [1.0, 0.0, 0.0, 0.0]
until, heard = time.monotonic() + 60, None
while heard is None and time.monotonic() < until:
    state.tick += 10
    robot.publish_low_state(state)
    time.sleep(0.01)
    # A command with a wrong checksum is not taken.
    command = robot.read_incoming_command()
    if any(command.kd):
        heard = command
kp, kd = ({round(gain, 6) for gain in gains} for gains in ((heard.kp, heard.kd) if heard else ([], [])))
cpp_wire.say(f"heard {heard is not None} kp {sorted(kp)} kd {sorted(kd)}")
# The switcher's answers are served on.
while time.monotonic() < until:
    time.sleep(0.02)
