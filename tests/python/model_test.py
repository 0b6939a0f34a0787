#!/usr/bin/python3
"""Models: what is set is what the program takes for set, and what is refused changes nothing."""

import copy
import pickle
import unittest

from support import RECORD, InFolder, program, program_json, untimed

import armukf

ARM = "Fv Fc Fcs alpha beta J a_m a_g k_g1 k_g3 d_g k_a d_a".split()


class Changes(InFolder):
    def test_the_published_arm(self):
        model = armukf.Model()
        self.assertEqual(list(model.parameters), ARM)
        self.assertEqual(model.unknowns, ARM[6:])
        k_a = model.parameters["k_a"]
        self.assertEqual((k_a.value, k_a.unit, k_a.lower, k_a.upper, k_a.known),
                         (20.23072060978318, "N.m/rad", 0.0, float("inf"), False))
        self.assertEqual(armukf.Model.published_estimate()["k_a"], 11.7552)
        self.assertEqual(model.states, ["twist_gear", "twist_arm", "speed_motor", "speed_gear", "speed_arm"])

    def test_changes_are_chained_and_are_the_programs(self):
        model = armukf.Model().set(k_a=12.0, J=0.03).free("J", "Fv").fix("k_g3").add_effect("torque_bias")
        self.assertEqual(model["k_a"], 12.0)
        self.assertEqual(model.unknowns, ["Fv", "J", "a_m", "a_g", "k_g1", "d_g", "k_a", "d_a", "torque_bias"])
        self.assertEqual(model.effects, ["torque_bias"])
        wanted = program_json("estimate", RECORD, "--set", "k_a=12", "--set", "J=0.03", "--free", "J", "--free",
                              "Fv", "--fix", "k_g3", "--effect", "torque_bias")
        del wanted["input"]  # what became of the file's rows
        self.assertEqual(untimed(armukf.estimate(RECORD, model).json), wanted)

    def test_settings_by_their_names_in_a_model_file(self):
        model = armukf.Model().set({"noise.sensor": 0.05, "noise.model_error.gain": 0, "filter.kind": "ekf",
                                    "propagation.steps": 2, "race.starts": [{}, {"k_a": 0.5}]})
        settings = model.settings
        self.assertEqual((settings["noise"]["sensor"], settings["filter"]["kind"]), (0.05, "ekf"))
        self.assertEqual(settings["noise"]["model_error"],
                         {"start": 16.0, "least": 0.0, "gain": 0.0, "time_s": 0.3})
        self.assertEqual((settings["propagation"]["steps"], settings["race"]["starts"]), (2, [{}, {"k_a": 0.5}]))

    def test_bounds(self):
        model = armukf.Model().bound("k_a", 5, 30)
        self.assertEqual((model.parameters["k_a"].lower, model.parameters["k_a"].upper), (5.0, 30.0))
        self.assertEqual(model.bound("k_a", upper=25).parameters["k_a"].lower, 5.0)
        self.assertEqual(model.bound("k_a", lower=1).parameters["k_a"].lower, 1.0)  # wider again
        self.refused("bound:1: parameters.k_a: lower must be at least 0, not -1", model.bound, "k_a", -1)

    def test_an_effect_comes_and_goes(self):
        model = armukf.Model().add_effect("backlash", "torque_ripple", "torque_ripple:2")
        self.assertEqual(model.effects, ["backlash", "torque_ripple", "torque_ripple:2"])
        for name in model.effects:
            self.assertEqual(model.remove_effect(name).effects.count(name), 0)
        self.assertEqual(model, armukf.Model())
        self.assertIn("backlash", armukf.effect_names())

    def test_what_is_refused_changes_nothing(self):
        model = armukf.Model()
        known = ", ".join(ARM)
        for message, change in (
                (f"set:2: parameters.k_b: unknown parameter 'k_b'; known are: {known}",
                 lambda: model.set(k_a=12, k_b=1)),
                ("set:1: parameters.k_a: value -3 is outside of its bounds 0 to inf N.m/rad",
                 lambda: model.set(k_a=-3)),
                ("set:1: parameters.k_a.value: must be a number", lambda: model.set(k_a="soft")),
                ("set:1: parameters.k_a.value: must be a number, not nan", lambda: model.set(k_a=float("nan"))),
                ("a object is no value of a model file", lambda: model.set(k_a=object())),
                ("set:1: noise.sensor: must be above 0, not 0", lambda: model.set({"noise.sensor": 0})),
                (f"free:1: parameters.x: unknown parameter 'x'; known are: {known}", lambda: model.free("k_a", "x")),
                ("bound:1: parameters.k_a: lower, 50, must be below upper, 2", lambda: model.bound("k_a", 50, 2)),
                ("add_effect:1: effects[1]: unknown effect 'rust'; known are: "
                 + ", ".join(armukf.effect_names()), lambda: model.add_effect("backlash", "rust"))):
            self.refused(message, change)
            self.assertEqual(model, armukf.Model())
        with self.assertRaises(armukf.InputError):  # more than a value may not be smuggled in
            model.set({"k_a.value = 3\n[noise]\nsensor": 1})

    def test_inertia_that_is_used_up_is_refused(self):
        with self.assertRaisesRegex(armukf.InputError, r"a_m \+ a_g must be below 1"):
            armukf.Model().set(a_m=0.5, a_g=0.5)


class Files(InFolder):
    def test_a_saved_model_is_the_programs(self):
        path = self.folder / "model.toml"
        model = armukf.Model().set({"k_a": 12.3, "noise.sensor": 0.07}).add_effect("backlash").free("J")
        model.save(path)
        self.assertEqual(armukf.Model(path), model)
        self.assertEqual(armukf.Model(str(path)), model)
        program("simulate", "-o", self.folder / "run.csv", "--model", path, "--save", self.folder / "again.toml",
                "--quiet")
        self.assertEqual(armukf.Model(self.folder / "again.toml"), model)
        self.assertEqual(armukf.Model.from_text(model.text()), model)

    def test_a_faulty_file_is_said_as_the_program_says_it(self):
        path = self.folder / "model.toml"
        path.write_text("[noise]\nsensor = -1\n")
        self.refused(f"{path}:2: noise.sensor: must be above 0, not -1", armukf.Model, path)
        self.refused("mine:1: nois: unknown key; known are: belief, effects, limits, parameters, filter, propagation, "
                     "noise, prior, gate, race, adaptation", armukf.Model.from_text, "[nois]", "mine")
        self.refused("/nowhere.toml: cannot open: No such file or directory", armukf.Model, "/nowhere.toml")

    def test_copies_are_apart_and_pickles_are_whole(self):
        model = armukf.Model().set(k_a=12).add_effect("gravity")
        for other in (model.copy(), copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
            self.assertEqual(other, model)
            self.assertNotEqual(other.set(k_a=13), model)
        with self.assertRaises(TypeError):
            hash(model)

    def test_it_shows_itself(self):
        model = armukf.Model().add_effect("backlash")
        self.assertIn("unknown a_m, a_g", repr(model))
        self.assertRegex(model._repr_html_(), "^<table><caption>Model, effects: backlash</caption>.*</table>$")


if __name__ == "__main__":
    unittest.main()
