#!/usr/bin/env bash
# Trains with two ranks that have a network between them, and says how much of the speed the network takes.
#
# usage: benches/net/two-nodes.sh PROGRAM [ITERATIONS] [ROUNDS]
#   PROGRAM     paid with the feature mpi: cargo build --release --features mpi
#   ITERATIONS  of each training, the first two of which are not counted (default 30)
#   ROUNDS      pairs of a training with the limit and one without (default 3)
#
# The two nodes are network namespaces of this machine, each with a name of its own, joined by a pair of veth devices. The limit is
# 1 Gbit/s in each direction (tc tbf; RATE=10gbit for another) and, where the kernel has netem, a delay of 0.1 ms in each
# direction. Stage I on the built-in kicks, one rank of one thread on each node.
# Needs root, Open MPI, iproute2 and jq. Namespaces, devices and files are removed at the end.
set -euo pipefail

program=$(realpath "${1:?usage: two-nodes.sh PROGRAM [ITERATIONS] [ROUNDS]}")
iterations=${2:-30}
rounds=${3:-3}
rate=${RATE:-1gbit}

work=$(mktemp -d)
# The names are this run's own, so that it removes only what it has made.
names=(paid$$a paid$$b)
devices=(pv$$a pv$$b)
addresses=(10.77.0.1 10.77.0.2)
clean() {
  for name in "${names[@]}"; do
    ip netns pids "$name" 2>/dev/null | xargs -r kill 2>/dev/null || true
    ip netns delete "$name" 2>/dev/null || true
  done
  rm -rf "$work"
}
trap clean EXIT

for k in 0 1; do
  ip netns add "${names[k]}"
done
ip link add "${devices[0]}" netns "${names[0]}" type veth peer name "${devices[1]}" netns "${names[1]}"
for k in 0 1; do
  ip -n "${names[k]}" address add "${addresses[k]}/24" dev "${devices[k]}"
  ip -n "${names[k]}" link set lo up
  ip -n "${names[k]}" link set "${devices[k]}" up
done

# Runs a command on a node: in its network, and under its name, so that Open MPI takes the nodes for two machines.
on() {
  local k=$1
  shift
  ip netns exec "${names[k]}" unshare --uts sh -c 'hostname "$0" && exec "$@"' "node-$k" "$@"
}

# Open MPI starts its part on the other node with this instead of ssh: the address, then a command for a shell.
cat >"$work/agent" <<EOF
#!/bin/sh
shift
exec ip netns exec ${names[1]} unshare --uts sh -c 'hostname node-1 && eval "\$0"' "\$*"
EOF
chmod +x "$work/agent"

delay=none
limit() {
  for k in 0 1; do
    tc -n "${names[k]}" qdisc add dev "${devices[k]}" root handle 1: tbf rate "$rate" burst 256kb limit 4mb
    if tc -n "${names[k]}" qdisc add dev "${devices[k]}" parent 1: netem delay 0.1ms limit 10000 2>/dev/null; then
      delay='0.1 ms in each direction'
    fi
  done
}
unlimit() {
  for k in 0 1; do
    tc -n "${names[k]}" qdisc delete dev "${devices[k]}" root
  done
}

# A training; prints the samples a second of all iterations but the first two.
train() {
  local out=$work/$1
  on 0 env OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1 \
    mpirun -n 2 --host "${addresses[0]}:1,${addresses[1]}:1" --bind-to none \
    --mca plm_rsh_agent "$work/agent" --mca btl tcp,self --mca pml ob1 \
    --mca btl_tcp_if_include 10.77.0.0/24 --mca oob_tcp_if_include 10.77.0.0/24 \
    "$program" train stage1 --threads 1 --iterations "$iterations" --quiet --out "$out" \
    --set learn.ppo.balanced=true --set phases=[] >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  jq -s '(.[-1].samples - .[1].samples) / (.[-1].elapsed_s - .[1].elapsed_s) | round' "$out/metrics.jsonl"
  rm -rf "$out"
}

echo "two nodes on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), load $(cut -d' ' -f1 /proc/loadavg) before"
for round in $(seq "$rounds"); do
  free=$(train free)
  limit
  limited=$(train limited)
  unlimit
  echo "$free $limited" >>"$work/found"
  awk -v round="$round" -v rate="$rate" -v delay="$delay" '{ free = $1; limited = $2 } END {
    printf "round %d: without limit %d samples/s, with %s and delay %s %d samples/s: %.0f%% lost\n",
      round, free, rate, delay, limited, 100 * (1 - limited / free) }' "$work/found"
done
awk '{ free += $1; limited += $2 } END {
  printf "mean of %d: %d and %d samples/s: %.0f%% lost\n", NR, free / NR, limited / NR, 100 * (1 - limited / free) }' "$work/found"
