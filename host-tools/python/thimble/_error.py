"""The error of this package."""

from . import _thimble


class Error(Exception):
    """What went wrong and what to do.

    name: a short stable name, as in docs/cli.md ("unknown-key"). cause: one sentence. remedy: what to do. exit_code: that of the command
    `thimble`. issues: all errors of a scene, at most 20: a list of {"name", "cause", "remedy", "pointer", "line"}; [] for other errors. pointer is a
    JSON pointer ("/objects/0/shape/box/size_m"), line counts from 1 (0: the scene is no file)."""

    def __init__(self, name, cause, remedy, exit_code, issues=()):
        told = [f"{name}: {cause} ({remedy})"]
        told += [f"{issue['name']}: {issue['cause']} ({issue['remedy']})" for issue in issues if issue["cause"] != cause]
        super().__init__("\n".join(told))
        self.name, self.cause, self.remedy, self.exit_code, self.issues = name, cause, remedy, exit_code, list(issues)

    def __reduce__(self):
        return type(self), (self.name, self.cause, self.remedy, self.exit_code, self.issues)


_thimble.set_error_class(Error)
