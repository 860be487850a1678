"""Results that are kept by which objects they belong to."""

from asv_env import make_params
from asv_env.memo import MOST, by_identity
from asv_env.tasks.laws import rules


def counting():
    """A kept function of a list, and the lists that it was really called with."""
    calls = []

    @by_identity
    def total(numbers):
        calls.append(numbers)
        return sum(numbers)

    return total, calls


def test_a_result_is_computed_once_for_each_object():
    total, calls = counting()
    one, equal = [1, 2], [1, 2]
    assert [total(one), total(equal), total(one)] == [3, 3, 3]
    assert [id(call) for call in calls] == [id(one), id(equal)]


def test_an_object_that_takes_the_place_of_another_is_not_taken_for_it():
    total, _ = counting()
    assert [total([number]) for number in range(3 * MOST)] == list(range(3 * MOST))


def test_no_more_than_the_latest_results_are_kept():
    total, calls = counting()
    lists = [[number] for number in range(MOST + 1)]
    for numbers in (*lists, lists[-1], lists[0]):
        total(numbers)
    assert len(calls) == MOST + 2


def test_parameters_that_are_equal_have_equal_rules():
    assert rules(make_params()) == rules(make_params())
