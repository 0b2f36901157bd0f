from espalier import Environment


class Ceiling(Environment):
    """Answers 1 below the height 3 and 0 above it: what asks may not grow through the ceiling."""
    def answer(self, query):
        return [1 if query.position[1] < 3 else 0]


Ceiling.serve()
