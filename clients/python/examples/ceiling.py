from espalier import Environment


class Ceiling(Environment):
    """Answers 1 below the height 6 and 0 above it: no shoot grows through the ceiling."""
    def answer(self, query):
        return [1 if query.position[1] < 6 else 0]


Ceiling.serve()
