"""The sentence of a refusal as it goes over the wire: one line of bounded length."""

LONGEST_SENTENCE = 500


def one_sentence(reason: object) -> str:
    r"""
    Return the text of an error without line breaks and of at most LONGEST_SENTENCE characters.

    >>> one_sentence(ValueError('a\nb'))
    'a b'
    """
    text = ' '.join(str(reason).split())
    return text if len(text) <= LONGEST_SENTENCE else f'{text[: LONGEST_SENTENCE - 3]}...'
