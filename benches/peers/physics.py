"""Physics steps per second of engines that install from the registry and run without a GPU, next to ours, on the same cores.

The G1 of `paid eval scene` and its ball; a position servo in every joint holds the default pose. 5 ms steps. An engine that cannot load the
scene says why.

    v/bin/pip install -r requirements-physics.txt
    v/bin/python physics.py

MuJoCoUni is built for one version of MuJoCo, an older one, and needs an environment of its own:

    uni/bin/pip install -r requirements-uni.txt
    uni/bin/python physics.py --engines MuJoCo MuJoCoUni
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np
from g1 import PHYSICS_DT_S, ROOT, SUBSTEPS, Robots, scene, servos


def rate(step, steps: int, seconds: float) -> float:
    """Physics steps per second of `step`, which returns how many it made; the first call is not timed."""
    step()
    begin, count = time.perf_counter(), 0
    while time.perf_counter() - begin < seconds:
        step()
        count += 1
    return count * steps / (time.perf_counter() - begin)


def mujoco_rate(mjcf: Path, args) -> float:
    robots = Robots(mjcf, args.envs, args.threads, (160, 292), 1, ball=True)
    still = np.zeros((args.envs, 29))
    return rate(lambda: robots.step(still), SUBSTEPS * args.envs, args.seconds)


def motrix_rate(mjcf: Path, args) -> float:
    import motrixsim

    spec, default, _ = servos(mjcf)
    model = motrixsim.load_mjcf_str(spec.to_xml())
    data = motrixsim.SceneData(model, batch=(args.envs,))
    data.actuator_ctrls = np.tile(default.astype(np.float32), (args.envs, 1))
    return rate(lambda: model.step_n(data, SUBSTEPS), SUBSTEPS * args.envs, args.seconds)


def uni_rate(mjcf: Path, args) -> float:
    from mujoco_uni.batch_env import BatchEnvPool

    robots = Robots(mjcf, args.envs, args.threads, (160, 292), 1, ball=True)
    pool = BatchEnvPool(robots.model, nbatch=args.envs, nthread=args.threads)
    control = np.tile(robots.default, (args.envs, SUBSTEPS, 1))
    state = robots.state

    def step():
        nonlocal state
        state = pool.step(state, nstep=SUBSTEPS, control=control)

    return rate(step, SUBSTEPS * args.envs, args.seconds)


def mjx_rate(mjcf: Path, args) -> float:
    import jax
    from mujoco import mjx

    spec, default, _ = servos(mjcf)
    model = spec.compile()
    state = mujoco.MjData(model)
    state.ctrl[:] = default
    there = mjx.put_model(model)
    one = mjx.put_data(model, state)
    many = jax.vmap(lambda _: one)(np.arange(args.envs))
    advance = jax.jit(jax.vmap(lambda data: mjx.step(there, data)))

    def step():
        nonlocal many
        many = jax.block_until_ready(advance(many))

    return rate(step, args.envs, args.seconds)


def ours(args) -> float:
    command = [args.paid, "bench", "physics", "--json", "--no-mujoco", "--threads", args.threads, "--seconds", args.seconds]
    out = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True).stdout
    plane = next(row for row in json.loads(out)["rows"] if row["scene"] == "plane")
    return plane["all_cores"]["physics_steps_per_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--paid", type=Path, default=ROOT / "target/release/paid")
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=5.0, help="of a measurement")
    parser.add_argument("--engines", nargs="*", default=["MuJoCo", "MotrixSim", "MJX"])
    args = parser.parse_args()
    engines = {"MuJoCo": mujoco_rate, "MuJoCoUni": uni_rate, "MotrixSim": motrix_rate, "MJX": mjx_rate}
    base = ours(args)
    print(f"{'ours':<36}{base:>10.0f} steps/s, {1e3 * PHYSICS_DT_S:.0f} ms each; MuJoCo {mujoco.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        for soles in ("training", "vendor"):
            mjcf = scene(args.paid, soles, Path(folder))
            for name in args.engines:
                try:
                    found = engines[name](mjcf, args)
                    print(f"{name + ', feet: ' + soles:<36}{found:>10.0f} steps/s, ratio {base / found:.0f}")
                except Exception as error:  # Whatever a peer says goes into the table.
                    print(f"{name + ', feet: ' + soles:<36}failed: {type(error).__name__}: {str(error)[:150]}")


if __name__ == "__main__":
    main()
