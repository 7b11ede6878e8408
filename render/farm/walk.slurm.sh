#!/bin/bash
# Submits a walk to Slurm: tables, fill in chunks, merge, frames in chunks, each step when the one before it is done.
#   SCENE=hall.xml CAMERA_PATH=walk.csv OUT=/shared/walk FIRST=1 LAST=300 ./walk.slurm.sh
set -euo pipefail

: "${SCENE:?the scene}" "${CAMERA_PATH:?the path of the camera, CSV}" "${OUT:?folder that all machines see}"
: "${LAST:?last frame of the path}"
FIRST=${FIRST:-1} FILL_CHUNK=${FILL_CHUNK:-60} DRAW_CHUNK=${DRAW_CHUNK:-10}
RENDER=${RENDER:-render} OPTIONS=${OPTIONS:---method auto --width 320 --spp 8} SBATCH_OPTIONS=${SBATCH_OPTIONS:-}
export SCENE CAMERA_PATH OUT FIRST LAST FILL_CHUNK DRAW_CHUNK RENDER OPTIONS

walk() { $RENDER walk "$SCENE" --path "$CAMERA_PATH" $OPTIONS --tables "$OUT/tables" "$@"; }
# First frame of this task of an array, and last one.
chunk() {
    from=$((FIRST + SLURM_ARRAY_TASK_ID * $1)) to=$((from + $1 - 1))
    to=$((to < LAST ? to : LAST))
}

case ${1:-submit} in
tables) walk --preview --frames "$FIRST" -o "$OUT/preview/####.png" ;;
fill)
    chunk "$FILL_CHUNK"
    walk --fill-only --frames $from-$to --cache "$OUT/chunks/$from.cache" -o "$OUT/####.exr"
    ;;
merge) $RENDER cache merge "$OUT"/chunks/*.cache -o "$OUT/walk.cache" ;;
draw)
    chunk "$DRAW_CHUNK"
    walk --frames-only --skip-existing --frames $from-$to --cache "$OUT/walk.cache" -o "$OUT/####.exr"
    ;;
submit)
    mkdir -p "$OUT/tables" "$OUT/chunks" "$OUT/log"
    tasks() { echo $(((LAST - FIRST) / $1)); }
    # Slurm runs a copy of this file, with the variables that are exported above.
    submit() { sbatch --parsable --export=ALL --output="$OUT/log/%x-%j.txt" $SBATCH_OPTIONS "$@"; }
    tables=$(submit --job-name=tables "$0" tables)
    fill=$(submit --job-name=fill --dependency=afterok:$tables --array=0-$(tasks "$FILL_CHUNK") "$0" fill)
    merge=$(submit --job-name=merge --dependency=afterok:$fill "$0" merge)
    draw=$(submit --job-name=draw --dependency=afterok:$merge --array=0-$(tasks "$DRAW_CHUNK") "$0" draw)
    echo "tables $tables, fill $fill, merge $merge, draw $draw"
    ;;
*)
    echo "$0: what is $1?" >&2
    exit 2
    ;;
esac
