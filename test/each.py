"""One test over many files, names or rows: it goes through all, and fails with a line for each that is wrong."""

import inspect


def each_row(names, rows, name=str):
    """
    Make one case of a test function and the rows of a table, as ``pytest.mark.parametrize`` makes one of each.

    Parameters
    ----------
    names : str or tuple of str
        Of the arguments that a row gives, or of the one that it is; other arguments are fixtures, the same ones for all
        rows.
    rows : iterable
        What the function is called with, one after the other.
    name : callable
        Returns how a row is called in the message.

    """
    rows = list(rows)
    several = not isinstance(names, str)

    def decorate(test):
        def case(**fixtures):
            assert rows
            wrong = []
            for row in rows:
                try:
                    test(**fixtures, **(dict(zip(names, row, strict=True)) if several else {names: row}))
                except Exception as error:
                    wrong.append(f'{name(row)}: {type(error).__name__}: {error}')
            assert not wrong, '\n'.join(wrong)

        signature = inspect.signature(test)
        case.__name__, case.__doc__, case.__module__ = test.__name__, test.__doc__, test.__module__
        case.__signature__ = signature.replace(parameters=[
            parameter for parameter in signature.parameters.values()
            if parameter.name not in (names if several else [names])])
        return case

    return decorate


def each(items, name=str):
    """Make one case of a test function that takes nothing but one item: `each_row` without the argument's name."""
    return lambda test: each_row(*inspect.signature(test).parameters, items, name)(test)
