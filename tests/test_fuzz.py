"""Texts from anywhere are shown as they are, and a refusal is all there is to say."""

from linecontact.studies.command_line import main as cli
from linecontact.studies.terminal import console


def test_text_is_shown_as_it_is(capfd):
    console.Output().print("[red]a[/blue] :smile: \x1b[31m\udc80")
    assert capfd.readouterr().out == "[red]a[/blue] :smile: \\x1b[31m\\udc80\n"


def test_too_little_memory_is_one_line(capfd):
    def greedy():
        raise MemoryError("8 EiB")

    assert console.guard(greedy) == 2
    assert capfd.readouterr().err.count("\n") == 1


def test_a_refusal_is_all_there_is_to_say(capfd):
    assert cli.main(["study", "peers", "--workers", "0"]) == 2
    assert capfd.readouterr().err.count("\n") == 1
