"""One test over many files or names: it goes through all, and fails with a line for each that is wrong."""


def each(items, name=str):
    """
    Make one case of a test function that takes one item.

    Parameters
    ----------
    items : iterable
        What it is called with, one after the other.
    name : callable
        Returns how an item is called in the message.

    """
    items = list(items)

    def decorate(test):
        def case():
            assert items
            wrong = []
            for item in items:
                try:
                    test(item)
                except Exception as error:
                    wrong.append(f'{name(item)}: {type(error).__name__}: {error}')
            assert not wrong, '\n'.join(wrong)

        case.__name__, case.__doc__, case.__module__ = test.__name__, test.__doc__, test.__module__
        return case

    return decorate
