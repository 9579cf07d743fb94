"""help(thimble) is complete: every public name is explained, with the units and shapes of what it takes and gives."""

import inspect
import pydoc
import unittest

import thimble


def public():
    """Every public name with its object: those of the module, and those of its classes."""
    for name in thimble.__all__:
        thing = getattr(thimble, name)
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and not inspect.ismemberdescriptor(value):
                    yield f"{name}.{member}", value


class Help(unittest.TestCase):
    def test_every_public_name_is_explained(self):
        for name, thing in public():
            with self.subTest(name=name):
                text = inspect.getdoc(getattr(thing, "func", thing)) or ""
                self.assertGreater(len(text), 20, "no docstring")
                self.assertTrue(text[0].isupper() or text[0].isdigit() or text.split()[0].isidentifier(), text)
                self.assertTrue(text.rstrip().endswith((".", ")")), text)

    def test_arguments_are_explained(self):
        """Every parameter of a public function or class stands in its docstring."""
        for name, thing in public():
            if not (inspect.isfunction(thing) or inspect.isclass(thing)):
                continue
            try:
                parameters = inspect.signature(thing).parameters
            except ValueError:
                continue
            text = inspect.getdoc(thing).lower()
            for parameter, how in parameters.items():
                if parameter != "self" and thing is not thimble.Error and how.kind not in (how.VAR_POSITIONAL, how.VAR_KEYWORD):
                    with self.subTest(name=name, parameter=parameter):
                        self.assertIn(parameter.lower(), text)

    def test_units_and_shapes(self):
        for name, words in (("simulate", ("n x 3", "rate_Hz", "World frame")), ("Sim.step", ("m;", "2 x 3")), ("Recording.counts", ("n x arms x 3",)),
                            ("Device.order_force", ("newtons",)), ("Device.telemetry", ("n x 3", "force_N")), ("Arm.jacobian", ("3 x axes",)),
                            ("Tip", ("newtons", "metres")), ("sphere", ("In m.", "From 1e-05 to 10."))):
            thing = thimble
            for part in name.split("."):
                thing = inspect.getattr_static(thing, part)
            text = inspect.getdoc(getattr(thing, "func", thing))
            for word in words:
                self.assertIn(word, text, name)

    def test_help_has_all_of_it(self):
        text = pydoc.plain(pydoc.render_doc(thimble))
        for name in thimble.__all__:
            self.assertRegex(text, rf"\b{name}\b")


if __name__ == "__main__":
    unittest.main()
