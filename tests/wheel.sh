#!/bin/sh
# Use an installed robimp away from its source: tests/wheel.sh BIN SPEC. Exits non-zero at the first surprise.
set -eu
bin=$1 spec=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$spec" spec.yaml
"$bin/robimp" --help >/dev/null
"$bin/robimp" synth spec.yaml -o result
"$bin/robimp" check result/certificate.json --spec spec.yaml
"$bin/python" -I -m robimp.synthesis.check result/certificate.json
sed 's/  inertia: 0.03 /  inertia: 0.031 /' spec.yaml >other.yaml
if "$bin/robimp" check result/certificate.json --spec other.yaml 2>message; then
    echo "a certificate of another specification was accepted" >&2
    exit 1
fi
grep -q 'plant.inertia' message
