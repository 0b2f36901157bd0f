"""The plate of heat.hxx in Python: a component with the Basic Model Interface that knows nothing of Espalier.

It has the functions that an environment needs; the others of the interface are left out.
"""

import numpy


class Heat:
    """Configuration: four numbers, nodes along y, nodes along x, the distance of nodes in m, and the share of the difference to its
    neighbours that a node gets in a step. At first the middle of the plate has the temperature 100."""

    def initialize(self, config_file):
        with open(config_file, encoding="utf-8") as file:
            rows, columns, spacing, share = file.read().split()
        self.shape, self.spacing, self.share = (int(rows), int(columns)), float(spacing), float(share)
        self.temperature = numpy.zeros(self.shape)
        self.temperature.flat[self.temperature.size // 2] = 100.0
        self.loss = numpy.zeros(self.shape)

    def update(self):
        before = self.temperature
        change = numpy.zeros(self.shape)
        change[1:] += self.share * (before[:-1] - before[1:])
        change[:-1] += self.share * (before[1:] - before[:-1])
        change[:, 1:] += self.share * (before[:, :-1] - before[:, 1:])
        change[:, :-1] += self.share * (before[:, 1:] - before[:, :-1])
        self.temperature = before + change - self.loss

    def finalize(self):
        pass

    def get_value(self, name, dest):
        dest[:] = self.temperature.ravel()
        return dest

    def set_value(self, name, src):
        self.loss = numpy.reshape(src, self.shape)

    def get_var_units(self, name):
        return "K"

    def get_var_grid(self, name):
        return 0

    def get_var_type(self, name):
        return "float64"

    def get_var_itemsize(self, name):
        return 8

    def get_var_nbytes(self, name):
        return 8 * self.temperature.size

    def get_grid_type(self, grid):
        return "uniform_rectilinear"

    def get_grid_rank(self, grid):
        return 2

    def get_grid_shape(self, grid, shape):
        shape[:] = self.shape
        return shape

    def get_grid_spacing(self, grid, spacing):
        spacing[:] = self.spacing
        return spacing

    def get_grid_origin(self, grid, origin):
        origin[:] = 0.0, -self.spacing * (self.shape[1] // 2)
        return origin
