# run.sh PYTHON BUILD TESTS: runs a file of tests of the Python package that was built.
python=$1 build=$2 tests=$3
ls "$build"/python/partscribe/_native*.so >/dev/null 2>&1 ||
  { echo "skipped: there is no Python module; it needs pybind11-dev and python3-dev"; exit 0; }
"$python" -c "import numpy, pytest" 2>/dev/null ||
  { echo "skipped: $python has no numpy or no pytest; script/setup installs them"; exit 0; }
PYTHONPATH=$build/python PYTHONDONTWRITEBYTECODE=1 exec "$python" -m pytest -q -rs -p no:cacheprovider "$tests"
