"""A battery on the vendor's SDK that says its charge, 63%, or a listener to another one.

sdk_battery.py says|hears DOMAIN INTERFACE
"""

import sys
import time

from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelPublisher, ChannelSubscriber
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import BmsState_

ChannelFactoryInitialize(int(sys.argv[2]), sys.argv[3])
# The test ends this program; left alone it ends by itself.
until = time.monotonic() + 120
if sys.argv[1] == "says":
    cells = [4000 + k for k in range(40)]
    volts = [54000, 53000, 52000]
    state = BmsState_(1, 2, 3, cells, volts, -1500, 63, 97, list(range(12)), 77, 2024, [5] * 5, [9] * 3)
    # The first four bytes say which encoding follows.
    print("says", state.serialize()[4:].hex(), flush=True)
    out = ChannelPublisher("rt/lf/bmsstate", BmsState_)
    out.Init()
    while time.monotonic() < until:
        out.Write(state)
        time.sleep(0.02)
else:
    heard = []
    into = ChannelSubscriber("rt/lf/bmsstate", BmsState_)
    into.Init(heard.append, 10)
    while not heard and time.monotonic() < until:
        time.sleep(0.02)
    print("heard", *[(state.soc, state.soh, state.current, sum(state.cell_vol)) for state in heard[:1]], flush=True)
