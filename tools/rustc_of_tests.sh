#!/bin/sh
# The compiler as `make test` and `make long` call it (RUSTC_WRAPPER): unit tests of these packages compile without optimisation.
#
# A program of unit tests contains its package once more, beside the library that ships, and the optimiser takes most of the time of its
# compilation. Tests of the packages below compute little: their time is that of the engine, which they link as it ships. Everything else
# is compiled as Cargo asks.
compiler=$1
shift
case " $* " in
*" --test "*) ;;
*) exec "$compiler" "$@" ;;
esac
case " $* " in
*" --crate-name foldwing_file "* | *" --crate-name foldwing_fmi "* | *" --crate-name foldwing_fmu "* | *" --crate-name foldwing_import "* | *" --crate-name foldwing_recording "* | *" --crate-name foldwing_study "*) ;;
*) exec "$compiler" "$@" ;;
esac
for word; do
    shift
    case $word in
    opt-level=*) word=opt-level=0 ;;
    esac
    set -- "$@" "$word"
done
exec "$compiler" "$@"
