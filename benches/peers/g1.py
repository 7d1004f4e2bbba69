"""The G1 of `paid eval scene` as a vectorized environment: MuJoCo's own thread pool steps it, numpy does the rest.

Observation and reward are simpler than the project's (no bodies' poses, no tables of terms), which favors this side of the comparison.
"""

import json
import math
import re
import struct
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout

ROOT = Path(__file__).resolve().parents[2]
# As the project's presets: physics at 200 Hz, control at 50 Hz.
PHYSICS_DT_S = 0.005
SUBSTEPS = 4
FALLEN_M = 0.4


@dataclass(frozen=True)
class Sizes:
    """Lengths of the two observations and of the networks' layers."""

    observations: tuple[int, int]
    hidden: tuple[int, ...]


def network_sizes(checkpoint: Path) -> Sizes:
    """Reads them from the header of a checkpoint of ours."""
    with checkpoint.open("rb") as file:
        (length,) = struct.unpack("<Q", file.read(8))
        header = json.loads(file.read(length))
    contract = json.loads(header["__metadata__"]["paid"])
    return Sizes((contract["policy_obs"], contract["critic_obs"]), tuple(contract["actor"]["hidden"]))


def matched(patterns: list[dict], joint: str) -> float:
    """The value of the last entry whose joint pattern matches; 0 without one."""
    value = 0.0
    for entry in patterns:
        if re.fullmatch(re.escape(entry["joint"]).replace(r"\*", ".*"), joint):
            value = entry["value"]
    return value


def scene(paid: Path, soles: str, folder: Path) -> Path:
    """Lets the program write its evaluation scene, at the training's physics step."""
    out = folder / f"{soles}.xml"
    settings = out.with_suffix(".toml")
    training = str(soles == "training").lower()
    settings.write_text(f"physics_dt_s = {PHYSICS_DT_S}\ntraining_soles = {training}\n")
    command = [paid, "eval", "scene", "--scene", settings, "--out", out]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return out


def servos(mjcf: Path, ball: bool = True) -> tuple[mujoco.MjSpec, np.ndarray, np.ndarray]:
    """The scene with a position servo in the place of every motor, so that the joint control runs in the engine and not in Python; the
    default angles and the radians of a unit of action."""
    with (ROOT / "configs/robots/g1.toml").open("rb") as file:
        robot = tomllib.load(file)
    spec = mujoco.MjSpec.from_file(str(mjcf))
    if not ball:
        spec.delete(spec.body("ball"))
    spec.body("pelvis").pos[2] = robot["nominal_height_m"]
    omega = 2 * math.pi * robot["natural_frequency_hz"]
    default, scale = [], []
    for actuator in spec.actuators:
        joint = spec.joint(actuator.target)
        stiffness = joint.armature * omega**2
        damping = 2 * robot["damping_ratio"] * joint.armature * omega
        effort = actuator.ctrlrange[1]
        actuator.gainprm[0] = stiffness
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.biasprm[1], actuator.biasprm[2] = -stiffness, -damping
        actuator.forcelimited, actuator.forcerange = True, [-effort, effort]
        actuator.ctrllimited = False
        default.append(matched(robot["default_pos"], actuator.target))
        scale.append(robot["action_scale_factor"] * effort / stiffness)
    return spec, np.array(default), np.array(scale)


class Robots:
    """Many G1s."""

    def __init__(
        self, mjcf: Path, envs: int, threads: int, observations: tuple[int, int], seed: int, ball: bool = False
    ):
        spec, self.default, self.scale = servos(mjcf, ball)
        self.model = spec.compile()
        self.envs = envs
        self.data = [mujoco.MjData(self.model) for _ in range(threads)]
        self.pool = rollout.Rollout(nthread=threads)
        self.rng = np.random.default_rng(seed)
        self.observations = observations
        nq = self.model.nq
        joints = [self.model.joint(actuator.target) for actuator in spec.actuators]
        # FULLPHYSICS begins with the time, then qpos, then qvel.
        self.qpos = np.array([1 + j.qposadr[0] for j in joints])
        self.qvel = np.array([1 + nq + j.dofadr[0] for j in joints])
        self.base = slice(1, 8)
        self.base_vel = slice(1 + nq, 7 + nq)
        start = mujoco.MjData(self.model)
        start.qpos[:] = self.model.qpos0
        start.qpos[self.qpos - 1] = self.default
        size = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.start = np.empty(size)
        mujoco.mj_getState(self.model, start, self.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.state = np.tile(self.start, (envs, 1))
        self.out = np.empty((envs, SUBSTEPS, size))
        self.phase = self.rng.uniform(0, 2 * math.pi, envs)
        self.last = np.zeros((envs, len(joints)))

    def reference(self) -> np.ndarray:
        """A motion to follow: every joint swings a little about its default angle."""
        return self.default + 0.1 * np.sin(self.phase[:, None] + np.arange(len(self.default)))

    def observe(self) -> tuple[np.ndarray, np.ndarray]:
        state = self.state
        parts = [
            self.reference(),
            state[:, self.base],
            state[:, self.base_vel],
            state[:, self.qpos] - self.default,
            state[:, self.qvel],
            self.last,
        ]
        known = np.concatenate(parts, axis=1, dtype=np.float32)
        # What else the project's observation holds is zeros here: as wide, and cheaper.
        return tuple(fitted(known, length) for length in self.observations)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        target = self.default + self.scale * action
        control = np.repeat(target[:, None, :], SUBSTEPS, axis=1)
        self.pool.rollout(self.model, self.data, self.state, control, state=self.out)
        self.state = self.out[:, -1].copy()
        self.phase += 0.1
        error = ((self.state[:, self.qpos] - self.reference()) ** 2).mean(axis=1)
        reward = np.exp(-error / 0.25) - 0.01 * ((action - self.last) ** 2).sum(axis=1)
        self.last = action
        fallen = (self.state[:, 3] < FALLEN_M) | ~np.isfinite(self.state).all(axis=1)
        self.state[fallen] = self.start
        self.last[fallen] = 0.0
        return reward.astype(np.float32), fallen


def fitted(rows: np.ndarray, length: int) -> np.ndarray:
    """Cut or filled with zeros to this length."""
    out = np.zeros((len(rows), length), np.float32)
    width = min(length, rows.shape[1])
    out[:, :width] = rows[:, :width]
    return out
