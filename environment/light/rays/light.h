#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `light`: sun and sky on the organs of all plants, by rays (leaf_light.h), with bounces between organs
/// that reflect and let light pass, in several bands of the spectrum.
///
/// Of every band a query gets four numbers about the organ that the module behind it draws: what a unit of its area
/// absorbs, what it absorbs in all, what falls on a unit of its area (both sides together) and what falls on it in all;
/// W/m² and W, or µmol m⁻² s⁻¹ and µmol s⁻¹. Area is that of one side of a leaf, or of the mantle of a segment. When
/// the module behind draws nothing the query is a sensor: the third number is the irradiance of a horizontal plane at
/// its place, from the sky and the sun, the others are 0.
///
/// The sun stands still (`sunDirection`), or moves by the world's latitude, longitude and start (universal time)
/// through the step; light is the mean over the step. Its strength is then 1361 W/m² at the mean distance, times τ^m
/// through air of the optical mass m = 1/sin(elevation); the sky has 0.3 (1 − τ^m) of what the sun would give a
/// horizontal plane (Liu & Jordan 1960; Campbell & Norman 1998). Nothing outlasts a step but the rays that no change of
/// the plants can have touched, which are not traced again; what comes back is the same, bit by bit.
extern const ProcessEntry kLightProcess;

}  // namespace espalier::environment
