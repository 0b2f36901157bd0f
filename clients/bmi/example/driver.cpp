// A driver of BMI models that knows nothing of plants, and a plant as its model: driver CONFIGURATION [INPUT VALUE]
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "clients/bmi/espalier_bmi.h"

void drive(bmi::Bmi& model, int count, char** arguments) {
  model.Initialize(arguments[1]);
  model.UpdateUntil(model.GetEndTime() / 2.0);
  if (count == 4) {
    double value = std::atof(arguments[3]);
    model.SetValue(arguments[2], &value);
  }
  while (model.GetCurrentTime() < model.GetEndTime()) {
    model.Update();
    std::printf("%g %s", model.GetCurrentTime(), model.GetTimeUnits().c_str());
    for (const std::string& name : model.GetOutputVarNames()) {
      double value = 0.0;
      model.GetValue(name, &value);
      std::printf("  %s %.17g %s", name.c_str(), value, model.GetVarUnits(name).c_str());
    }
    std::printf("\n");
  }
  model.Finalize();
}

int main(int count, char** arguments) {
  if (count != 2 && count != 4) {
    std::fprintf(stderr, "give a configuration, then an input and its value\n");
    return 2;
  }
  try {
    espalier::bmi::EspalierBmi model;
    drive(model, count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
