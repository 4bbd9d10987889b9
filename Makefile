# Everything needs only python3 (3.11 or newer) and make: the first target that wants it builds .venv.
PYTHON ?= python3
BIN := .venv/bin
export OPENBLAS_NUM_THREADS := 1

.PHONY: demo test docs evidence lint types wheel bench bench-simulation rivals picture clean

demo: .venv/installed
	$(BIN)/robimp synth examples/haninger2016.yaml

test: .venv/installed
	$(BIN)/python -m pytest -n 2

# Into build/docs, without network; every warning is an error.
docs: .venv/installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

# The full sizes of tests/evidence; mutants of the checker are tried for BUDGET seconds, the next call goes on.
BUDGET ?= 600
evidence: .venv/installed
	$(BIN)/python tests/evidence/run.py
	$(BIN)/python tests/evidence/mutation.py --budget $(BUDGET) --record out/mutants.jsonl

lint: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# The built wheel, installed in an environment of its own and used from an empty folder.
wheel: .venv/installed
	rm -rf build dist && $(BIN)/python -m build --wheel --outdir dist . >/dev/null
	$(PYTHON) -m venv --clear build/env
	build/env/bin/python -m pip install -q --disable-pip-version-check -c constraints.txt dist/*.whl
	sh tests/wheel.sh "$(CURDIR)/build/env/bin" "$(CURDIR)/examples/haninger2016.yaml"

# mypy reads the wheel's files where they are installed: the packages have other names than their folders here.
types: wheel
	cd build && ../$(BIN)/mypy --config-file ../pyproject.toml --python-executable env/bin/python \
	    -p robimp.models -p robimp.synthesis

bench: .venv/installed
	$(BIN)/python benchmarks/bench.py

# What people would use instead, on the same problems: about forty minutes. Rivals whose package is missing are skipped.
rivals: .venv/installed
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[bench]'
	$(BIN)/python benchmarks/rivals

# Against LSODA, python-control and C (needs gcc); about a minute.
bench-simulation: .venv/installed
	$(BIN)/python benchmarks/simulation.py

picture: .venv/installed
	$(BIN)/python examples/picture.py

clean:
	rm -rf .venv build dist out *.egg-info

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[test,dev,docs]'
	touch $@
