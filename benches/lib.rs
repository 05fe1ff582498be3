//! Contains only the benchmarks next to this file: `make bench`.
