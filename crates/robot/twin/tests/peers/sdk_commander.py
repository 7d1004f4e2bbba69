"""A small low-level program on the vendor's SDK: releases the vendor's controller, then moves the left elbow by 0.3 rad.

sdk_commander.py DOMAIN INTERFACE
"""

import sys
import time

from unitree_sdk2py.comm.motion_switcher.motion_switcher_client import MotionSwitcherClient
from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelPublisher, ChannelSubscriber
from unitree_sdk2py.idl.default import unitree_hg_msg_dds__LowCmd_
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowCmd_, LowState_
from unitree_sdk2py.utils.crc import CRC

JOINTS, ELBOW = 29, 18
ChannelFactoryInitialize(int(sys.argv[1]), sys.argv[2])
crc = CRC()
seen = {"states": 0, "wrong": 0, "last": None}


def on_state(state):
    seen["states"] += 1
    # Every tenth: the checksum is slow in Python.
    if seen["states"] % 10 == 0:
        seen["wrong"] += crc.Crc(state) != state.crc
    seen["last"] = state


def wait_for(what, condition, seconds=60):
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            print("missing", what, flush=True)
            sys.exit(1)
        time.sleep(0.05)


states = ChannelSubscriber("rt/lowstate", LowState_)
states.Init(on_state, 10)
switcher = MotionSwitcherClient()
switcher.SetTimeout(2.0)
switcher.Init()
wait_for("states", lambda: seen["last"] is not None)


def master():
    code, answer = switcher.CheckMode()
    return answer["name"] if code == 0 else None


names = []
wait_for("an answer of the motion switcher", lambda: names.append(master()) or names[-1] is not None)
print("master", repr(names[-1]), flush=True)
while master() != "":
    switcher.ReleaseMode()
print("released", flush=True)

commands = ChannelPublisher("rt/lowcmd", LowCmd_)
commands.Init()
command = unitree_hg_msg_dds__LowCmd_()
begin = [seen["last"].motor_state[j].q for j in range(JOINTS)]
for step in range(300):
    command.mode_pr, command.mode_machine = 0, seen["last"].mode_machine
    for j in range(JOINTS):
        motor = command.motor_cmd[j]
        motor.mode, motor.dq, motor.tau, motor.kp, motor.kd = 1, 0.0, 0.0, 60.0, 2.0
        motor.q = begin[j] + (0.3 * min(step / 100, 1.0) if j == ELBOW else 0.0)
    command.crc = crc.Crc(command)
    commands.Write(command)
    time.sleep(0.01)
moved = seen["last"].motor_state[ELBOW].q - begin[ELBOW]
print("moved", moved, "states", seen["states"], "wrong", seen["wrong"], flush=True)
