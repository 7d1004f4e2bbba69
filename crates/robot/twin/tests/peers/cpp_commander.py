"""A small low-level program on the vendor's C++ SDK: moves the left elbow of a released robot by 0.3 rad.

cpp_commander.py DOMAIN
"""

import sys
import time

import cpp_wire
import unitree_interface as sdk

JOINTS, ELBOW = 29, 18
robot = cpp_wire.open_g1(int(sys.argv[1]))
# It looks at the checksum itself, and takes no state with a wrong one.
until = time.monotonic() + 60
while robot.read_low_state().mode_machine == 0:
    if time.monotonic() > until:
        print("missing states", flush=True)
        sys.exit(1)
    time.sleep(0.05)
state = robot.read_low_state()
begin = list(state.motor.q)
upright = state.imu.quat[0] > 0.99
cpp_wire.say(f"machine {state.mode_machine} upright {upright} casing {state.motor.temperature[0]}")
command = sdk.MotorCommand(JOINTS)
command.dq_target, command.tau_ff = [0.0] * JOINTS, [0.0] * JOINTS
command.kp, command.kd = [60.0] * JOINTS, [2.0] * JOINTS
moved, step = 0.0, 0
# It may be heard some seconds later than it hears.
while step < 300 or (moved < 0.25 and time.monotonic() < until):
    target = list(begin)
    target[ELBOW] += 0.3 * min(step / 100, 1.0)
    command.q_target = target
    robot.write_low_command(command)
    time.sleep(0.01)
    moved, step = robot.read_low_state().motor.q[ELBOW] - begin[ELBOW], step + 1
cpp_wire.say(f"moved {moved}")
