"""Training samples per second: ours against MuJoCo with threads and PPO in PyTorch, in turns on the same cores.

    python3 -m venv v && v/bin/pip install -r requirements.txt
    cargo build --release -p paid
    v/bin/python train.py
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import torch
from g1 import ROOT, Robots, network_sizes, scene
from torch import nn

# As `paid train stage1`: horizon, passes, minibatches.
HORIZON, EPOCHS, MINIBATCHES = 24, 2, 8
GAMMA, LAMBDA, CLIP = 0.99, 0.95, 0.2
ACTIONS = 29


def mlp(inputs: int, hidden: tuple[int, ...], outputs: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(inputs, width), nn.ELU()]
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))


class Ppo:
    """PPO with the clipped objective, GAE and Adam, nothing beyond."""

    def __init__(self, robots: Robots, sizes):
        self.robots = robots
        self.actor = mlp(sizes.observations[0], sizes.hidden, ACTIONS)
        self.critic = mlp(sizes.observations[1], sizes.hidden, 1)
        self.log_std = nn.Parameter(torch.full((ACTIONS,), -1.0))
        self.parameters = [*self.actor.parameters(), *self.critic.parameters(), self.log_std]
        self.adam = torch.optim.Adam(self.parameters, lr=1e-3)
        self.spent = {"engine and task": 0.0, "networks forward": 0.0, "update": 0.0}

    def clocked(self, part: str, since: float) -> float:
        now = time.perf_counter()
        self.spent[part] += now - since
        return now

    def iteration(self) -> int:
        robots, steps = self.robots, []
        clock = time.perf_counter()
        for _ in range(HORIZON):
            seen = [torch.from_numpy(x) for x in robots.observe()]
            clock = self.clocked("engine and task", clock)
            with torch.no_grad():
                mean, value = self.actor(seen[0]), self.critic(seen[1])[:, 0]
                policy = torch.distributions.Normal(mean, self.log_std.exp())
                action = policy.sample()
                log_prob = policy.log_prob(action).sum(1)
            clock = self.clocked("networks forward", clock)
            reward, done = robots.step(action.numpy().astype(np.float64))
            steps.append((*seen, action, log_prob, value, torch.from_numpy(reward), torch.from_numpy(done)))
            clock = self.clocked("engine and task", clock)
        with torch.no_grad():
            value = self.critic(torch.from_numpy(robots.observe()[1]))[:, 0]
        obs, critic_obs, action, log_prob, values, reward, done = (torch.stack(x) for x in zip(*steps))
        advantage, carried = torch.zeros_like(reward), torch.zeros(robots.envs)
        for t in reversed(range(HORIZON)):
            going = 1.0 - done[t].float()
            delta = reward[t] + GAMMA * going * value - values[t]
            carried = delta + GAMMA * LAMBDA * going * carried
            advantage[t], value = carried, values[t]
        returns = advantage + values
        advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        batch = [x.flatten(0, 1) for x in (obs, critic_obs, action, log_prob, advantage, returns)]
        count = HORIZON * robots.envs
        for _ in range(EPOCHS):
            for part in torch.randperm(count).chunk(MINIBATCHES):
                self.minibatch(*(x[part] for x in batch))
        self.clocked("update", clock)
        return count

    def minibatch(self, obs, critic_obs, action, log_prob, advantage, returns):
        policy = torch.distributions.Normal(self.actor(obs), self.log_std.exp())
        ratio = (policy.log_prob(action).sum(1) - log_prob).exp()
        gain = torch.minimum(ratio * advantage, ratio.clamp(1 - CLIP, 1 + CLIP) * advantage)
        value = (self.critic(critic_obs)[:, 0] - returns).square().mean()
        loss = -gain.mean() + value - 0.0005 * policy.entropy().sum(1).mean()
        self.adam.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(self.parameters, 1.0)
        self.adam.step()


def theirs(args, sizes, mjcf: Path) -> dict:
    torch.manual_seed(1)
    ppo = Ppo(Robots(mjcf, args.envs, args.threads, sizes.observations, 1), sizes)
    ppo.iteration()
    ppo.spent = dict.fromkeys(ppo.spent, 0.0)
    begin, samples = time.perf_counter(), 0
    while time.perf_counter() - begin < args.seconds:
        samples += ppo.iteration()
    wall = time.perf_counter() - begin
    return {"samples_per_s": samples / wall, "shares": {k: v / wall for k, v in ppo.spent.items()}}


def ours(args) -> float:
    command = [args.paid, "bench", "train", "--preset", "stage1", "--json"]
    command += ["--envs", args.envs, "--threads", args.threads, "--seconds", args.seconds]
    out = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True).stdout
    return json.loads(out)["samples_per_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--paid", type=Path, default=ROOT / "target/release/paid")
    parser.add_argument("--checkpoint", type=Path, default=ROOT / "policies/demo/stage1.safetensors")
    parser.add_argument("--envs", type=int, default=1920)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=15.0, help="of a measurement")
    parser.add_argument("--rounds", type=int, default=2, help="the two take turns")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    sizes = network_sizes(args.checkpoint)
    rounds = []
    with tempfile.TemporaryDirectory() as folder:
        scenes = {soles: scene(args.paid, soles, Path(folder)) for soles in ("training", "vendor")}
        for _ in range(args.rounds):
            of = {"ours": ours(args)}
            for soles, mjcf in scenes.items():
                of[soles] = theirs(args, sizes, mjcf)
            rounds.append(of)
            if not args.json:
                report(of)
    if args.json:
        print(json.dumps({"envs": args.envs, "threads": args.threads, "sizes": sizes.__dict__, "rounds": rounds}))


def report(of: dict):
    print(f"ours                                {of['ours']:>10.0f} samples/s")
    for soles, name in (("training", "the built-in engine's soles"), ("vendor", "the vendor's feet")):
        found = of[soles]
        rate, shares = found["samples_per_s"], found["shares"]
        parts = ", ".join(f"{part} {100 * share:.0f}%" for part, share in shares.items())
        print(f"MuJoCo + PyTorch, {name:<27}{rate:>8.0f} samples/s, ratio {of['ours'] / rate:.1f} ({parts})")


if __name__ == "__main__":
    main()
