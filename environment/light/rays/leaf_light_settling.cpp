#include <algorithm>
#include <cmath>

#include "environment/light/rays/leaf_light.h"

namespace espalier::environment {

using core::Vec3;

namespace {

/// More rounds than light of any stand needs: of a closed white room a part of 10⁻⁴ leaves in each.
constexpr int kMostRounds = 100'000;

}  // namespace

LeafLight::Balance LeafLight::settle(std::size_t band, const std::vector<double>& sky,
                                     const std::vector<LightMaterial>& materials, double remainder, const Vec3& up,
                                     const std::optional<double>& incoming) const {
  Balance balance;
  balance.irradiances = irradiances(band, sky, materials, {}, 0);
  if (incoming) {
    giveTheGroundTheRest(*incoming, up, balance.irradiances);
  }
  // power that leaves each side
  std::vector<double> power(balance.irradiances.size());
  const auto scatter = [&](const std::vector<double>& arrived) {
    double sum = 0.0;
    for (std::size_t side = 0; side < power.size(); ++side) {
      const LightMaterial& material = materials[surfaces_.material[side / 2]];
      power[side] = material.reflectance * arrived[side] + material.transmittance * arrived[side ^ 1U];
      sum += power[side];
    }
    return sum;
  };
  std::vector<double> arrived(power.size());
  double first = 0.0;
  for (std::size_t side = 0; side < power.size(); ++side) {
    arrived[side] = balance.irradiances[side] * areas_[side / 2];
    first += arrived[side];
  }
  double left = scatter(arrived);
  for (int round = 0; round < kMostRounds && left > remainder * first; ++round) {
    std::fill(arrived.begin(), arrived.end(), 0.0);
    for (std::size_t row = 0; row < wanted_.size(); ++row) {
      shoot(row, power, up, arrived, balance);
    }
    for (std::size_t side = 0; side < power.size(); ++side) {
      if (arrived[side] != 0.0) {
        balance.irradiances[side] += arrived[side] / areas_[side / 2];
      }
    }
    left = scatter(arrived);
  }
  gather(band, sky, materials, remainder * first, balance);
  return balance;
}

/// Lets the organs gather what the sides of all triangles send, until what they send themselves has changed by less
/// than a power.
void LeafLight::gather(std::size_t band, const std::vector<double>& sky, const std::vector<LightMaterial>& materials,
                       double leastChange, Balance& balance) const {
  const std::size_t organSides = 2 * std::min(surfaces_.groundBegin, surfaces_.triangles.size());
  balance.gathered = balance.irradiances;
  balance.sent.resize(balance.irradiances.size());
  double change = HUGE_VAL;
  for (int round = 0; round < kMostRounds && change > leastChange; ++round) {
    for (std::size_t side = 0; side < balance.sent.size(); ++side) {
      const LightMaterial& material = materials[surfaces_.material[side / 2]];
      balance.sent[side] =
          material.reflectance * balance.gathered[side] + material.transmittance * balance.gathered[side ^ 1U];
    }
    const std::vector<double> now = irradiances(band, sky, materials, balance.sent, 0);
    change = 0.0;
    for (std::size_t side = 0; side < organSides; ++side) {
      const LightMaterial& material = materials[surfaces_.material[side / 2]];
      change += std::abs(now[side] - balance.gathered[side]) * areas_[side / 2] *
                (material.reflectance + material.transmittance);
      balance.gathered[side] = now[side];
    }
  }
}

/// The incoming light that the plants leave falls on the ground, spread as its own rays say: many leaves know it better
/// than the few cells of the ground.
void LeafLight::giveTheGroundTheRest(double incoming, const Vec3& up, std::vector<double>& irradiances) const {
  double plants = 0.0;
  double seen = 0.0;
  double area = 0.0;
  for (std::size_t triangle = 0; triangle < areas_.size(); ++triangle) {
    const double both = (irradiances[2 * triangle] + irradiances[2 * triangle + 1]) * areas_[triangle];
    (triangle < surfaces_.groundBegin ? plants : seen) += both;
    area += triangle < surfaces_.groundBegin ? 0.0 : areas_[triangle];
  }
  const double rest = std::max(incoming - plants, 0.0);
  if (plants > incoming) {
    for (std::size_t side = 0; side < 2 * surfaces_.groundBegin; ++side) {
      irradiances[side] *= incoming / plants;
    }
  }
  for (std::size_t triangle = surfaces_.groundBegin; triangle < areas_.size(); ++triangle) {
    const std::size_t upper = 2 * triangle + (core::dot(normals_[triangle], up) >= 0.0 ? 0U : 1U);
    irradiances[upper] = seen > 0.0 ? irradiances[upper] * (rest / seen) : rest / area;
    irradiances[upper ^ 1U] = 0.0;
  }
}

/// Sends the power of both sides of a triangle along its rays for that.
void LeafLight::shoot(std::size_t row, const std::vector<double>& power, const Vec3& up, std::vector<double>& arrived,
                      Balance& balance) const {
  const std::uint32_t triangle = wanted_[row];
  const std::array<double, 2> own{power[2 * triangle], power[2 * triangle + 1]};
  if (own[0] == 0.0 && own[1] == 0.0) {
    return;
  }
  const auto lattice = sendingOf(triangle);
  std::array<double, 2> weights{};
  for (std::size_t i = 0; i < lattice.count; ++i) {
    const double cosine = core::dot(directions_.all()[lattice.begin + i], normals_[triangle]);
    weights[cosine >= 0.0 ? 0 : 1] += std::abs(cosine);
  }
  const std::uint32_t* hits = hits_.data() + rowStart_[row] + gatheringOf(triangle).count;
  for (std::size_t i = 0; i < lattice.count; ++i) {
    const Vec3& direction = directions_.all()[lattice.begin + i];
    const double cosine = core::dot(direction, normals_[triangle]);
    const std::size_t side = cosine >= 0.0 ? 0 : 1;
    const double part = own[side] * std::abs(cosine) / weights[side];
    if (hits[i] != kSky) {
      arrived[hits[i]] += part;
    } else {
      (core::dot(direction, up) > 0.0 ? balance.leavingUp : balance.leavingDown) += part;
    }
  }
}

}  // namespace espalier::environment
