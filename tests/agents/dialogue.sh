#!/bin/sh
# dialogue.sh PARTSCRIBE SCAN-FOLDER: runs dialogue.mjs where node and the client are installed.
set -eu
cd "$(dirname "$0")"
if ! command -v node >/dev/null || ! [ -d node_modules/@modelcontextprotocol ]; then
  echo "skipped: node or the protocol's client is not installed; script/setup --with-agents installs both"
  exit 0
fi
exec node dialogue.mjs "$@"
