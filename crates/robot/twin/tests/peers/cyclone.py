"""CycloneDDS at the other end of the wire: says one message again and again, and tells the bytes of what it hears.

cyclone.py SIDE DOMAIN: SIDE is 'robot' (says LowState, hears LowCmd) or 'runtime' (the other way round). The types are declared here again.
"""

import sys
import time
from dataclasses import dataclass

import cyclonedds.idl as idl
import cyclonedds.idl.annotations as annotate
import cyclonedds.idl.types as types
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

u32x = lambda n: types.array[types.uint32, n]
f32x = lambda n: types.array[types.float32, n]


@dataclass
@annotate.final
class MotorCmd_(idl.IdlStruct, typename="unitree_hg.msg.dds_.MotorCmd_"):
    mode: types.uint8
    q: types.float32
    dq: types.float32
    tau: types.float32
    kp: types.float32
    kd: types.float32
    reserve: types.uint32


@dataclass
@annotate.final
class LowCmd_(idl.IdlStruct, typename="unitree_hg.msg.dds_.LowCmd_"):
    mode_pr: types.uint8
    mode_machine: types.uint8
    motor_cmd: types.array[MotorCmd_, 35]
    reserve: u32x(4)
    crc: types.uint32


@dataclass
@annotate.final
class IMUState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.IMUState_"):
    quaternion: f32x(4)
    gyroscope: f32x(3)
    accelerometer: f32x(3)
    rpy: f32x(3)
    temperature: types.int16


@dataclass
@annotate.final
class MotorState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.MotorState_"):
    mode: types.uint8
    q: types.float32
    dq: types.float32
    ddq: types.float32
    tau_est: types.float32
    temperature: types.array[types.int16, 2]
    vol: types.float32
    sensor: u32x(2)
    motorstate: types.uint32
    reserve: u32x(4)


@dataclass
@annotate.final
class LowState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.LowState_"):
    version: u32x(2)
    mode_pr: types.uint8
    mode_machine: types.uint8
    tick: types.uint32
    imu_state: IMUState_
    motor_state: types.array[MotorState_, 35]
    wireless_remote: types.array[types.uint8, 40]
    reserve: u32x(4)
    crc: types.uint32


def motor_cmd(k):
    return MotorCmd_(1, 0.1 * k - 1.5, -0.25 * k, 0.5 * k, 40.0 + k, 2.0 + 0.125 * k, 7 * k)


def motor_state(k):
    reserve = [k, k + 1, k + 2, k + 3]
    return MotorState_(1, 0.1 * k - 1.0, 0.5 * k, -0.25 * k, 1.5 * k, [40 + k, -k], 54.5, [k, 2 * k], 3 * k, reserve)


def low_cmd():
    return LowCmd_(0, 5, [motor_cmd(k) for k in range(35)], [1, 2, 3, 4], 0xAABBCCDD)


def low_state():
    imu = IMUState_([1.0, 0.0, 0.25, 0.0], [0.1, 0.2, 0.3], [0.0, 0.0, 9.75], [0.5, -0.5, 1.5], -12)
    motors = [motor_state(k) for k in range(35)]
    return LowState_([1, 2], 0, 5, 4711, imu, motors, list(range(40)), [9, 8, 7, 6], 0x01020304)


def main():
    side, domain = sys.argv[1], int(sys.argv[2])
    participant = DomainParticipant(domain)
    state = Topic(participant, "rt/lowstate", LowState_)
    command = Topic(participant, "rt/lowcmd", LowCmd_)
    out, into, say = (state, command, low_state()) if side == "robot" else (command, state, low_cmd())
    writer, reader = DataWriter(participant, out), DataReader(participant, into)
    # The first four bytes say which encoding follows.
    print("says", say.serialize()[4:].hex(), flush=True)
    heard = False
    # The test ends this program; left alone it ends by itself.
    until = time.monotonic() + 120
    while time.monotonic() < until:
        writer.write(say)
        for sample in reader.take(8):
            if not heard and isinstance(sample, (LowCmd_, LowState_)):
                heard = True
                print("heard", sample.serialize()[4:].hex(), sample.crc, flush=True)
        time.sleep(0.02)


main()
