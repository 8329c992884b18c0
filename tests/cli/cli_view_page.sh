#!/bin/bash
# The page of `ricochet view` in headless Chromium. SHOTS=FOLDER keeps pictures of it.
set -u
. tests/support/tap.sh

skip() { echo "1..0 # SKIP $1"; exit 77; }
if "$ricochet" view /dev/null 2>&1 | grep -q 'built without'; then skip 'this program was built without the page'; fi
browser=$(browser_there) || skip 'chromium is missing'
command -v node >/dev/null || skip 'node is missing'
[ -e web/node_modules/playwright-core/package.json ] || skip 'web/node_modules has no playwright-core'
# what runs for seconds only is not worth to be compiled twice
node --no-opt web/node_modules/typescript/bin/tsc --noEmit -p web || { echo 'not ok 1 - the types of the page'; echo '1..1'; exit 1; }
if grep -q __tsan_init "$ricochet"; then
    echo '# with thread checks the atlas of a million points, an hour then, is left out'
    export PART=demo
fi
node tests/cli/view_page.mjs "$ricochet" "$browser" "$folder" ${SHOTS:+"$SHOTS"}
