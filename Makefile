# The two commands of the README, and what they are made of. Needs Python >= 3.11, make and a C compiler.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

ifeq ($(shell uname -m),x86_64)  # one kernel of BLAS on every machine: others round otherwise, and searches end elsewhere
export OPENBLAS_CORETYPE ?= Haswell
endif

.PHONY: playground playground-test demo quick net test slow targets fuzz viewers lint types doctest wheel golden docs notebooks closed-forms bench bars accuracy clean

demo: $(READY)  ## print the two-link equations, generate and verify the PUMA 560 modules
	$(BIN)/symdyn equations examples/two_link.toml
	$(BIN)/symdyn generate examples/puma560.toml --target numpy -o build/demo
	$(BIN)/symdyn generate examples/puma560.toml --target c -o build/demo
	$(BIN)/symdyn verify examples/puma560.toml

quick: $(READY)  ## a minute: what starts no compiler, browser or LaTeX and takes no long
	$(BIN)/python -m pytest --quick -n auto --maxprocesses 4 --dist worksteal

net: $(READY)  ## half a minute: whether the program of any example has changed, by hashes
	$(BIN)/python tests/net.py --compare --programs

test: $(READY)  ## what must hold, every claim in some cases
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal --durations=20 --durations-min=1

slow: $(READY)  ## all other cases, and what takes minutes: robots against Pinocchio, 3,000 mechanisms against the reference of tests/engine
	$(BIN)/python -m pip install --quiet -e '.[dev,bench]'
	$(BIN)/python -m pytest -m slow -n auto --maxprocesses 4

targets: build/targets/.ready  ## what takes a heavy runtime: CasADi, JAX, PyTorch, Octave, rustc, OpenCL, FMPy
	build/targets/bin/python -m pytest -m targets -n auto --maxprocesses 2 -rs --durations=20 --durations-min=1

SECONDS ?= 600
SEED ?= 1

fuzz: $(READY)  ## cases by grammar and by mutation, in workers with limits: make fuzz SECONDS=600
	$(BIN)/python -m tests.fuzz --seconds $(SECONDS) --seed $(SEED)

viewers: $(READY)  ## pictures and films in programs of others: librsvg, Chromium, poppler, three.js, Khronos' validator
	$(BIN)/python -m pytest -m "" tests/test_draw_files.py tests/test_draw_films.py tests/test_draw_gltf.py

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)  ## mypy on all of it, pyright on the code of README and docs
	$(BIN)/mypy
	$(BIN)/python tests/typed_pages.py

doctest: $(READY)
	$(BIN)/python -m pytest --doctest-modules --doctest-ignore-import-errors symdyn  # of what is not installed: JAX, PyTorch
	$(BIN)/python -m pytest --doctest-glob='*.md' README.md CONTRIBUTING.md docs/index.md docs/python.md docs/equations.md docs/regressors.md \
		docs/identify.md docs/sweeps.md docs/simulate.md docs/control.md docs/excitation.md docs/units.md docs/verify.md docs/questions.md docs/robots.md docs/recipes.md \
		docs/teaching/README.md

wheel: $(READY)  ## the sdist, the wheel that it builds, and that wheel alone in an empty environment
	$(BIN)/python tests/wheel.py

golden: $(READY)  ## rewrite generated/, docs/walkthroughs/ and what the verbs take after a change that is meant
	$(BIN)/python -m pytest -m "" tests/test_options_table.py tests/test_generated.py tests/test_fmu.py tests/test_teach_examples.py --update-golden

playground: $(READY)  ## the page on which scenes are written, with Python inside, in build/playground; takes npm
	$(BIN)/python docs/site/playground/bundle.py build/playground
	@echo "python3 -m http.server -d build/playground"

playground-test: playground  ## that page in Chromium, and its stand-in for NumPy against NumPy
	$(BIN)/python -m pytest -m playground tests/test_playground_site.py tests/test_playground_numerical.py tests/test_teach_math_editor.py

docs: $(READY)  ## the site of documentation, in build/site, with the playground where it is made; a warning is an error
	$(BIN)/sphinx-build -q -W --keep-going -E -c docs/site -d build/doctrees docs build/site
	$(BIN)/python tests/searched.py build/site
	if [ -d build/playground ]; then rm -rf build/site/playground && cp -r build/playground build/site/playground; fi
	@echo build/site/index.html

notebooks: $(READY)  ## run every notebook of docs and write what its cells show
	$(BIN)/python tests/notebooks.py docs/notebooks/*.ipynb docs/gallery/*.ipynb docs/teaching/*.ipynb

closed-forms: $(READY)  ## time of all coefficients in closed form
	$(BIN)/python benchmarks/closed_forms.py

accuracy: $(READY)  ## run time against error of the examples, and the hard cases; writes docs/accuracy.md
	$(BIN)/python -m pip install --quiet -e '.[simulate]'
	$(BIN)/python benchmarks/accuracy_page.py

bench: $(READY)  ## side by side with other libraries; updates docs/performance.md
	$(BIN)/python -m pip install --quiet -e '.[bench]'
	$(BIN)/python benchmarks/run.py --docs docs
	$(BIN)/python benchmarks/derivatives.py --docs docs

# Each prints what was set out to be reached beside what was; some end with 1 where that was missed.
bars: $(READY)  ## the rest of what was set out to be reached: cold starts, certificates, large mechanisms, small batches, 31 digits, contacts, second derivatives, exact Hessians, inverse kinematics, calibration, stances of a quadruped, what nvcc spills; with DRAKE=PYTHON, ACADOS=PYTHON, FIGAROH=PYTHON beside these
	-$(BIN)/python benchmarks/import_time.py
	-$(BIN)/python benchmarks/cold_load.py
	-$(BIN)/python benchmarks/certificates.py
	-$(BIN)/python benchmarks/large_mechanisms.py
	-$(BIN)/python benchmarks/python_calls.py
	-$(BIN)/python benchmarks/two_threads.py
	-$(BIN)/python benchmarks/accuracy_levels.py
	-$(BIN)/python benchmarks/double_double.py
	-$(BIN)/python benchmarks/contacts.py
	-$(BIN)/python benchmarks/contact_steps.py
	-$(BIN)/python benchmarks/second_derivatives.py
	-$(BIN)/python benchmarks/exact_hessians.py
	-$(BIN)/python benchmarks/inverse_kinematics.py
	-$(BIN)/python benchmarks/calibration.py --seeds 20 $(if $(FIGAROH),--figaroh $(FIGAROH))
	-$(BIN)/python benchmarks/stances.py
	-$(if $(DRAKE),PYTHONPATH=tests $(BIN)/python benchmarks/sdf_drake.py $(DRAKE))
	-$(if $(ACADOS),$(BIN)/python benchmarks/acados_model.py $(ACADOS))
	-$(BIN)/python benchmarks/gpu.py --compile

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e '.[dev]'
	$(BIN)/python -c 'import matplotlib.font_manager'  # its list of fonts is made once: who makes it says so on stderr
	touch $@

build/targets/.ready: pyproject.toml
	$(PYTHON) -m venv build/targets
	build/targets/bin/python -m pip install --quiet --upgrade pip
	build/targets/bin/python -m pip install --quiet torch==2.13.0+cpu || build/targets/bin/python -m pip install --quiet torch
	build/targets/bin/python -m pip install --quiet -e '.[targets]'
	touch $@

clean:
	rm -rf $(VENV) build dist
