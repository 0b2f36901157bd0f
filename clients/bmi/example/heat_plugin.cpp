// The component Heat as an environment: plants take heat from the plate, which stands upright in the plane of x and y.
#include <heat.hxx>
#include "clients/bmi/bmi_plugin.h"

ESPALIER_BMI_ENVIRONMENT(std::make_unique<Heat>, .name = "heat", .configuration = "heat.cfg",
                         .output = "plate_surface__temperature", .demand = "plate_surface__heat_loss", .axes = "xy")
