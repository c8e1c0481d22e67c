#!/bin/sh
# A sweep in shards by GNU parallel, one of them killed on its way, must give the bytes of one run.
#
#   tests/cluster/parallel.sh [PROGRAM]      (default: target/release/impactscope)
set -eu
program=${1:-target/release/impactscope}
[ -x "$program" ] || { echo "$program is missing: cargo build --release" >&2; exit 1; }
program=$(cd "$(dirname "$program")" && pwd)/$(basename "$program")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
count=6
sweep="sweep --grid f=5:100:40Hz,V=2:9:30V --measure regime,contact,peak,drive_work"

"$program" $sweep --out whole.csv
# A shard that is killed leaves no file.
"$program" $sweep --shard "3/$count" --out 3.csv 2>/dev/null &
victim=$!
sleep 0.05
kill -KILL "$victim" 2>/dev/null || true
wait "$victim" 2>/dev/null || true
[ ! -e 3.csv ] || echo "the shard was done before it was killed" >&2
# Those that are done are left out, those that failed run again.
RAYON_NUM_THREADS=1 parallel --will-cite --retries 3 \
    "[ -s {}.csv ] || $program $sweep --shard {}/$count --out {}.csv" ::: $(seq $count) 2>/dev/null
# A shard that runs twice changes nothing.
"$program" $sweep --shard "2/$count" --out again.csv 2>/dev/null
"$program" sweep --merge again.csv [0-9]*.csv --out merged.csv
cmp whole.csv merged.csv
echo "parallel: $count shards, one killed, one twice: the same $(wc -c < merged.csv) bytes as one run"
