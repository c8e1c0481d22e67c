#!/usr/bin/env bash
# Recordings by an independent generator, one set for each effect of the catalogue, two with nothing
# concealed and three outside it, diagnosed by target/release/impactscope: what was concealed, the
# answer, and chi2 per value on the held-out recordings.   tests/other_hand/check.sh FIRST_SEED [FOLDER]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
first=${1:?the first seed}
folder=${2:-$(mktemp -d)}
program=$here/../../target/release/impactscope
seed=$first
for effect in amplifier_lag piezo_creep hysteresis_memory electrostatic extra_mode cubic_stiffness \
    quadratic_drag dry_friction film_spring long_range_attraction adhesion_saturation \
    velocity_restitution compliant_ground gap_step base_vibration zero_drift sensor_lag gravity \
    none none outside1 outside2 outside3; do
    # What acts in flight at half its usual size, the rest whole; between the branches and the loops
    # with memory there is nothing.
    case $effect in
    hysteresis_memory | adhesion_saturation | velocity_restitution | compliant_ground | gap_step | gravity | none) size=1 ;;
    *) size=0.5 ;;
    esac
    set=$folder/$effect-$seed
    python3 "$here/generate.py" --effect "$effect" --seed "$seed" --size $size --out "$set" >/dev/null
    held_out=()
    for file in "$set"/held*.csv; do held_out+=(--held-out "$file"); done
    "$program" diagnose "$set"/fit*.csv "${held_out[@]}" --json "$set/answer.json" >/dev/null 2>&1
    python3 - "$effect" "$set/answer.json" <<'END'
import json, sys
answer = json.load(open(sys.argv[2]))
held_out = answer["fit"]["held_out"]
names = "+".join(e["id"] for e in answer["effects"]) or "-"
print(f"{sys.argv[1]:22} {answer['verdict']:16} {names:40}",
      f"{held_out['before']['chi2']:.3f} to {held_out['after']['chi2']:.3f}")
END
    seed=$((seed + 1))
done
