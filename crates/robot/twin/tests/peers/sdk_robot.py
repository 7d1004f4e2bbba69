"""A robot on the vendor's SDK that stands still: says its state, and tells what commands it hears.

sdk_robot.py DOMAIN INTERFACE
"""

import sys
import time

from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelPublisher, ChannelSubscriber
from unitree_sdk2py.idl.default import unitree_hg_msg_dds__LowState_
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowCmd_, LowState_
from unitree_sdk2py.utils.crc import CRC

ChannelFactoryInitialize(int(sys.argv[1]), sys.argv[2])
crc = CRC()
commands = []
heard = ChannelSubscriber("rt/lowcmd", LowCmd_)
heard.Init(commands.append, 10)
out = ChannelPublisher("rt/lowstate", LowState_)
out.Init()
state = unitree_hg_msg_dds__LowState_()
state.mode_machine = 5
state.imu_state.quaternion = [1.0, 0.0, 0.0, 0.0]
state.wireless_remote = [0x55, 0x51] + [0] * 38
until = time.monotonic() + 60
while len(commands) < 200 and time.monotonic() < until:
    state.tick += 10
    state.crc = crc.Crc(state)
    out.Write(state)
    time.sleep(0.01)
some = commands[-20:]
right = all(crc.Crc(command) == command.crc for command in some)
damping = all((m.mode, m.kp, m.kd) == (1, 0.0, 3.0) for command in some for m in command.motor_cmd[:29])
machine = {command.mode_machine for command in some}
print("heard", len(commands) >= 200, "crc", right, "damping", damping, "machine", sorted(machine), flush=True)
