"""Everything that `make test` omits is run by `make validate` or another target."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import run_rust_tests  # noqa: E402
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")

# Sources of `tests/verification` and `tests/command` with studies that are short unless FOLDWING_WHOLE is set, and the number of places.
# Tests omitted altogether are `#[ignore]`d instead, so that they do not report ok.
SHORT = {
    "../command/verdicts.rs": 2,
    "conventional/angles.rs": 1,
    "conventional/double_pendulum.rs": 3,
    "conventional/product.rs": 1,
    "conventional/sample.rs": 1,
    "conventional/two_body.rs": 1,
    "coupling/agreement.rs": 1,
    "coupling/flutter.rs": 2,
    "coupling/lattice_modes.rs": 1,
    "coupling/linear_flutter.rs": 2,
    "coupling/linear_lattice.rs": 4,
    "coupling/linear_response.rs": 1,
    "lattice/linear.rs": 1,
    "lattice/unsteady.rs": 1,
    "linear_rows/mod.rs": 2,
    "pitch_link/rotor_5mw.rs": 3,
    "plant/chains.rs": 1,
    "plant/hybrid.rs": 2,
    "plant/rigid_latch.rs": 1,
    "rotor/linear.rs": 2,
    "turbine/operating.rs": 3,
    "turbine/operation.rs": 1,
    "turbine/periodic.rs": 2,
    "turbine/strain.rs": 2,
    "turbine/vacuum.rs": 1,
    "turbine/wind.rs": 7,
}

# The same for `tests/fmi`: the number of words WHOLE and whole, apart from their import.
SHORT_IN_PYTHON = {
    "test_casadi.py": 1,
    "test_failures.py": 1,
    "test_fmi3.py": 2,
    "test_live.py": 2,
    "test_model_exchange.py": 2,
    "test_wind_tunnel.py": 3,
}

# Tests that `make test` leaves to `make long`, which CI runs at every merge; each with a test of the same capability in `make test`.
LONG = {
    "rc02_random_calls_under_valgrind": "rc01_random_calls",
    "accounts_and_means_of_spatial_joints": "gradients_of_a_universal_joint",
    "accounts_pass_through_a_latch_and_a_stop": "accounts_pass_through_a_rigid_latch",
    "c11_ball_and_universal": "c10_ball_and_ball",
    "c12_ball_and_revolute": "c10_ball_and_ball",
    "c14_euler_parameters_in_root_or_parent_frame_give_one_motion": "c13_tip_meets_the_reference_up_to_1_s",
    "c20_rotation_angles_fail_at_their_singular_attitude": "c10_ball_and_ball",
    "c21_redundant_angles_need_tuning": "c10_ball_and_ball",
    "c22_penalty_joint_needs_tuning": "c10_ball_and_ball",
    "c40_product_follows_the_dense_model": "v03_residual_equals_dense_form",
    "d08_unloaded_libraries_leave_nothing": "test_f26_instantiating_and_freeing_leaves_memory_flat",
    "e14_rates_in_air_are_slopes_of_what_is_read": "e15_rates_hold_where_inputs_change_at_every_point",
    "flutter_names_the_divergence_of_a_wing_under_load": "flutter_names_what_no_speed_stands_for",
    "gradients_of_a_body_with_shear_on_a_ball_joint": "gradients_of_a_body_with_shear_through_a_rigid_latch",
    "gradients_of_bodies_with_shear": "gradients_of_a_body_with_shear_through_a_rigid_latch",
    "gradients_pass_through_more_failures": "gradients_pass_through_failures",
    "hy02_strips_tend_to_the_air_of_the_instant": "shipped_wing_unfolds_and_latches_under_an_integrator_from_outside",
    "pl23_root_strain_over_the_gear_inertia": "pl18_a_blade_that_bends",
    "q71_with_lift_small_inputs_move_the_linear_lattice_as_the_machine": "q71_small_inputs_move_the_linear_lattice_as_the_machine",
    "q76_listed_modes_are_the_slowest_of_the_whole_model": "q87_a_wing_of_many_elements_lists_all_its_modes",
    "q83_wings_that_bend_far_rest_on_the_path_from_still_air": "q84_divergence_ends_the_path_and_is_named",
    "q89_all_motions_between_the_axes_are_found": "q87_a_wing_of_many_elements_lists_all_its_modes",
    "rl14_random_chains_with_rigid_latches": "rl16_command_stopper_opening_and_closing_again",
    "s13_bend_of_45_degrees_under_smaller_loads": "s13_bend_of_45_degrees",
    "statics_leave_a_saddle_of_a_free_tip": "statics_in_a_lattice_judge_the_wing_with_its_air",
    "test_the_cost_of_an_iteration_is_linear_in_the_elements": "s19_cost_is_linear",
    "test_f95_soft_fold_script": "test_f92_soft_fold_halves_the_peak_strain",
    "test_f99_notebook_shows_what_it_says": "test_notebooks_show_what_they_store",
    "test_f292_roots_aside_and_turned": "test_f81_agrees_with_the_aircraft_in_one_piece",
    "test_f82_momentum_is_conserved_to_step_and_tolerance": "test_f83_centre_of_mass_follows_its_path",
    "test_notebooks_show_what_they_store[identify]": "test_f96_damping_recovered_from_noisy_records",
    "work_of_a_prescribed_motion": "accounts_with_inputs_over_time",
    "wt43_modes_of_the_turbine": "wt42_the_turbine_under_gravity",
    "wt45_the_turbine_in_wind": "wt42_the_turbine_under_gravity",
    "wt63_a_blade_in_strips": "wt62_what_swings_is_noticed",
    "wt64_floquet_beside_coleman": "wt42_the_turbine_under_gravity",
    "wt70_modes_in_strips": "wt72_modes_that_steps_follow",
    "wt76_small_bumps_of_the_wind": "wt77_the_rest_is_of_second_order",
    "wt78_exponents_are_floquets": "wt80_random_machines",
}

# Scripts that no target runs, with the reason.
RUN_OTHERWISE = {
    "importer_runs.py": "studies/importers.py starts it in the environment of the importers",
    "second_importer.py": "studies/importers.py imports it",
    "blade_frequencies.py": "by hand: the figures of one section of docs/validation",
    "cost_report.py": "imported by other studies",
    "machine_damping.py": "by hand: the table of decision 0082",
    "plot_aircraft.py": "imported by aircraft_study.py",
    "rigid_latch_gradient.py": "by hand: needs JAX and diffrax; row GR-41",
    "ptera_uvlm.py": "run by compare_lattice.py and plot_lattice_cost.py",
    "soft_blade.py": "by hand: the figures of one section of docs/validation",
    "wind_tunnel_cases.py": "imported by the studies of the wind tunnel",
    "wind_tunnel_flutter.py": "imported by wind_tunnel_study.py",
}

# Tests that may return before they have checked anything, with the reason.
RETURN_EARLY = {
    "rc02_random_calls_under_valgrind": "valgrind may be missing; not in CI and in `make valgrind`, where this is a failure",
}

# Optional packages that no environment has, with the reason.
NOT_INSTALLED = {
    "torch": "539 MB; GR-30 by hand",
}


def target(name):
    """Recipe of a target."""
    return re.search(rf"^{name}:.*\n((?:\t.*\n|#.*\n)*)", MAKEFILE, re.M).group(1)


def stages_of_validate():
    return re.search(r"^STAGES \?= (.*)$", MAKEFILE, re.M).group(1).split()


def test_validate_runs_all_its_stages():
    assert "$(STAGES)" in target("validate") and "--keep-going" in target("validate")
    written = set(re.findall(r"^(validate-[a-z0-9-]+):", MAKEFILE, re.M))
    assert written and written <= set(stages_of_validate())
    assert {"long", "robust"} <= set(stages_of_validate())
    assert all(target(stage) for stage in stages_of_validate())


def test_studies_that_are_short_are_listed():
    found = {}
    for folder, prefix in ((ROOT / "tests/verification", ""), (ROOT / "tests/command", "../command/")):
        for path in folder.rglob("*.rs"):
            count = path.read_text(encoding="utf-8").count("is_whole()")
            if count and path.name != "whole.rs":
                found[prefix + path.relative_to(folder).as_posix()] = count
    assert found == SHORT


def test_studies_in_python_that_are_short_are_listed_and_run_whole():
    found = {}
    for path in (ROOT / "tests/fmi").glob("test_*.py"):
        text = re.sub(r"^from conftest import .*$", "", path.read_text(encoding="utf-8"), flags=re.M)
        count = len(re.findall(r"(?<!\.)\bWHOLE\b|[=@]whole\b", text))
        if count:
            found[path.name] = count
    assert found == SHORT_IN_PYTHON
    assert re.search(r"^\tFOLDWING_WHOLE=1 \$\(MAKE\) pytest$", target("validate-pytest"), re.M)


def test_validate_runs_all_of_verification():
    """One call runs every test but those that it skips by name, and each of these has a stage of its own."""
    recipe = target("validate-tests")
    calls = [line for line in recipe.splitlines() if "--test verification" in line]
    assert len(calls) == 1
    assert "--test command" in calls[0] and "FOLDWING_WHOLE=1" in calls[0] and "--release" in calls[0] and "--include-ignored" in calls[0]
    arguments = calls[0].split(" -- ")[1].split()
    skipped = [name for word, name in zip(arguments, arguments[1:]) if word == "--skip"]
    assert set(arguments) - set(skipped) == {"--nocapture", "--include-ignored", "--skip"}
    assert re.findall(r"--include-ignored (\S+)$", target("validate-chains"), re.M) == skipped


def rust_tests(folders=("tests", "crates", "src", "benches")):
    """File, attributes, name, body and level of indentation of every Rust test."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.rs")):
            text = path.read_text(encoding="utf-8")
            for test in re.finditer(r"^( *)#\[test\]\n((?:\s*#\[.*\]\n)*)\s*fn (\w+)\(\)[^{\n]*\{\n((?s:.*?))^\1\}$", text, re.M):
                yield path, test[2], test[3], test[4], len(test[1]) + 4


CHECK = re.compile(r"\b(assert\w*!|hold\(|panic!)")


def unchecked_return(body, level):
    """The first line of a block of a test from which the test returns before it has checked anything."""
    begin = re.compile(rf"^ {{{level}}}\S.*", re.M)
    checked = False
    for line in begin.finditer(body):
        following = begin.search(body, line.end())
        block = body[line.start() : following.start() if following else len(body)]
        if not checked and re.search(r"\breturn( Ok\(\(\)\))?;|\{ return \};?", block):
            return line[0].strip()
        # what stands inside a condition may not run
        checked = checked or bool(CHECK.search(block)) and not re.match(r"(if|match)\b|\}", line[0].strip())
    return None


def test_no_test_says_ok_without_doing_anything():
    """A test that returns before it has checked anything is ignored, so that it does not report ok, or is listed with the reason."""
    found, count = {}, 0
    for path, marks, name, body, level in rust_tests():
        count += 1
        condition = unchecked_return(body, level)
        if condition and "model_of_child()" in condition:
            assert "#[ignore" in marks, f"{path.name}: {name}"
        elif condition:
            found[name] = condition
    assert count > 1800, count
    assert found.keys() == RETURN_EARLY.keys(), found


def test_tests_that_return_at_once_are_seen():
    assert unchecked_return("    if !is_whole() {\n        return;\n    }\n    assert!(true);\n", 4) == "if !is_whole() {"
    assert unchecked_return("    let Some(tool) = tool() else { return };\n    assert!(true);\n", 4) == "let Some(tool) = tool() else { return };"
    assert unchecked_return("    if no_tool() {\n        assert!(!is_ci());\n        return;\n    }\n    assert!(true);\n", 4) == "if no_tool() {"
    assert unchecked_return("    assert!(true);\n    if !is_whole() {\n        return;\n    }\n    assert!(true);\n", 4) is None
    assert unchecked_return("    for case in CASES {\n        assert!(case);\n    }\n    if !is_whole() {\n        return;\n    }\n", 4) is None


def path_of(file, program):
    """Path of a module in a test program: its name and those of its folders."""
    parts = file.relative_to(ROOT / "tests" / program).with_suffix("").parts
    return "".join(f"{part}::" for part in parts if part not in ("mod", "main"))


def left_out_by(arguments, tests):
    """The filters among the arguments of a test program that meet no test, or only ignored ones without the option that includes them."""
    words, filters, skipped = iter(arguments), [], []
    for word in words:
        if word == "--skip":
            skipped.append(next(words))
        elif not word.startswith("-"):
            filters.append(word)
    ignored = {"--include-ignored", "--ignored"} & set(arguments)
    run = [path for path, marks in tests if not any(part in path for part in skipped) and (ignored or not re.search(r"#\[ignore", marks))]
    return [word for word in filters if not any(word in path for path in run)]


def filtered_calls(text):
    """Test programs and arguments of the calls of `cargo test` that select tests."""
    for call in re.findall(r"(?:\$\(CARGO\)|cargo) test ([^`]*?)(?:`|$)", text, re.M):
        for_cargo, _, for_tests = call.partition(" -- ")
        programs = re.findall(r"--test (\w+)", for_cargo)
        if programs and for_tests:
            yield programs, for_tests.split()


def test_filters_of_targets_meet_tests():
    """A filter that meets no test, or an ignored one only, runs nothing and reports ok."""
    tests = {program.name: [(path_of(path, program.name) + name, marks) for path, marks, name, _, _ in rust_tests([f"tests/{program.name}"])]
             for program in (ROOT / "tests").iterdir() if (program / "main.rs").exists()}
    count = 0
    pages = [ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    for path, text in [(ROOT / "Makefile", MAKEFILE.replace("\\\n", ""))] + [(page, page.read_text(encoding="utf-8")) for page in pages]:
        for programs, arguments in filtered_calls(text):
            count += path.name == "Makefile"
            of_programs = [test for program in programs for test in tests[program]]
            assert not left_out_by(arguments, of_programs), f"{path.name}: {arguments}"
    assert count >= 8, count


def test_filters_that_meet_nothing_are_seen():
    tests = [("calls::rc01", ""), ("calls::rc02", '#[ignore = "long"]\n')]
    assert left_out_by(["--nocapture", "rc02"], tests) == ["rc02"]
    assert left_out_by(["--include-ignored", "rc02"], tests) == []
    assert left_out_by(["--skip", "rc01", "rc01", "calls::"], tests) == ["rc01", "calls::"]
    assert list(filtered_calls("\t$(CARGO) test --locked --test robustness -- --nocapture rc02\n")) == [(["robustness"], ["--nocapture", "rc02"])]


def test_ignored_tests_are_run_by_a_target():
    """Ignored tests are long, processes of other tests, or in a program that `make validate` runs with the ignored ones."""
    for path, marks, name, _, _ in rust_tests():
        for reason in re.findall(r'#\[ignore(?: = "(.*)")?\]', marks):
            whole = path.relative_to(ROOT).parts[:2] in (("tests", "verification"), ("tests", "command"))
            assert reason.startswith("a process of its own") or "`make long` runs it" in reason or whole and "make validate" in reason, name


def test_tests_that_skip_elsewhere_are_run_by_validate():
    """Where optional programs and libraries are missing tests are skipped; a stage of `make validate` has what they need."""
    clients = target("validate-clients")
    assert re.search(r"FOLDWING_WHOLE=1 .*\$\(CASADI\)/bin/python -m pytest .*tests/fmi/test_casadi.py", clients)
    assert re.search(r"\$\(OPTIONAL\)/bin/python -m pytest .*tests/python/test_differentiable.py", clients)
    assert re.search(r"^validate-pages: live-site$", MAKEFILE, re.M) and "-k live_site" in target("validate-pages")
    needed = {name for path in (ROOT / "tests").rglob("test_*.py") if path.name != "test_targets.py"
              for name in re.findall(r'importorskip\("(\w+)"', path.read_text(encoding="utf-8"))}
    given = "".join((ROOT / f"python/requirements-{name}.in").read_text(encoding="utf-8") for name in ("casadi", "optional", "package", "test"))
    missing = {name for name in needed if not re.search(rf"^{name.replace('_', '-')}\b", given, re.M)}
    assert missing == NOT_INSTALLED.keys()


def test_long_tests_have_a_short_one_beside_them():
    """Tests omitted from `make test` because of their duration are listed, CI runs them, and a test of the same capability remains."""
    run, left_out = set(), set()
    for folder in ("tests", "crates"):
        for path in (ROOT / folder).rglob("*.rs"):
            for marks, name in re.findall(r"#\[test\]\n((?:\s*#\[.*\]\n)*)\s*fn (\w+)\(", path.read_text(encoding="utf-8")):
                if "`make long` runs it" in marks:
                    left_out.add(name)
                elif "#[ignore" not in marks:
                    run.add(name)
    for path in (ROOT / "tests").rglob("test_*.py"):
        text = path.read_text(encoding="utf-8")
        marked = set(re.findall(r"@pytest\.mark\.long\n(?:@.*\n)*def (test_\w+)\(", text))
        left_out |= marked
        run |= set(re.findall(r"^def (test_\w+)\(", text, re.M)) - marked
        if path.name != "test_targets.py":
            left_out |= {f"test_notebooks_show_what_they_store[{case}]" for case in re.findall(r'param\("(\w+)", marks=pytest\.mark\.long\)', text)}
    assert left_out == LONG.keys()
    assert set(LONG.values()) <= run
    assert re.search(r"^ +make long LONG_SHARE=3\b", (ROOT / ".ci/run").read_text(encoding="utf-8"), re.M)
    assert "long" in stages_of_validate()


def test_assertions_run_in_part_in_ci_and_whole_in_validate():
    """Programs that CI selects exist; without a selection, `make assertions` and its stage of `make validate` run all."""
    ci = (ROOT / ".ci/run").read_text(encoding="utf-8")
    assert re.search(r'^ +make assertions ASSERTIONS="\$assertions" ASSERTIONS_SHARE=9$', ci, re.M)
    selected = re.search(r'^assertions="(.*)"$', ci, re.M).group(1).split()
    programs = [name for option, name in zip(selected, selected[1:], strict=False) if option == "--test"]
    assert "random" in programs and all((ROOT / f"tests/{name}/main.rs").is_file() for name in programs)
    assert "assertions" in stages_of_validate() and re.search(r"^ASSERTIONS \?=$", MAKEFILE, re.M)


def test_tests_of_a_share_of_their_cases_run_whole_in_long():
    """`make test`, `make assertions` and CI set the share, and `make long` runs every test that takes one, on all cases without CI."""
    found = set()
    for path in (ROOT / "tests").rglob("*.rs"):
        text = path.read_text(encoding="utf-8")
        for body in re.findall(r"#\[test\]\n *(?:#\[.*\]\n *)*fn (.*?)\n}\n", text, re.S):
            if re.search(r'\bshare\(\)|\bhold\("X-', body):
                found.add(body.split("(", 1)[0])
    assert found == run_rust_tests.SHARED
    assert MAKEFILE.count("FOLDWING_SHARE") == 3 and "FOLDWING_SHARE=3" in target("unit")
    assert "FOLDWING_SHARE=$(ASSERTIONS_SHARE)" in target("assertions") and re.search(r"^ASSERTIONS_SHARE \?= 3$", MAKEFILE, re.M)
    assert "FOLDWING_SHARE=$(LONG_SHARE)" in target("long") and re.search(r"^LONG_SHARE \?= 1$", MAKEFILE, re.M)
    # a stage of `make test` runs what `unit` skips, on as many cases
    assert re.findall(r"--skip (\S+)", target("unit")) == ["gr82_"] and re.search(r"FOLDWING_MACHINES=12 .* gr82_$", target("python"), re.M)
    arguments = re.search(r"run_rust_tests.py --long .*\n.*", target("long")).group()
    assert all(f"--test {program}" in arguments for program in ("verification", "random", "robustness", "command"))


def test_every_study_is_run_by_a_target():
    scripts = {path.name for path in (ROOT / "studies").glob("*.py")}
    run = {name for name in scripts if f"studies/{name}" in MAKEFILE}
    assert scripts - run == RUN_OTHERWISE.keys()
    for name, why in RUN_OTHERWISE.items():
        if why.startswith("imported"):
            module = Path(name).stem
            texts = [path.read_text(encoding="utf-8") for path in (ROOT / "studies").glob("*.py")]
            assert any(re.search(rf"\b(import|from) {module}\b", text) for text in texts), f"nothing imports {name}"
    assert "$(wildcard studies/audit/*.py)" in target("audit")


def test_slow_tests_are_tests():
    """Every test omitted from `make check` exists, so that the list cannot hide a later one of the same name."""
    functions = set()
    for folder in ("tests", "crates", "src"):
        for path in (ROOT / folder).rglob("*.rs"):
            functions |= set(re.findall(r"^\s*(?:pub )?fn (\w+)\(", path.read_text(encoding="utf-8"), re.M))
    listed = [line for line in (ROOT / "tests/slow_tests.txt").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert len(listed) > 100
    assert [name for name in listed if name.rsplit("::", 1)[-1] not in functions] == []
