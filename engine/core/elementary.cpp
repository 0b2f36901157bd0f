#include "engine/core/elementary.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

namespace espalier::core {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPiRest = 0x1.1a62633145c07p-53;  // pi is kPi + kPiRest

/// An angle in two parts, as hi + lo.
struct LongAngle {
  double hi;
  double lo;
};

// atan(1/2), atan(1), atan(3/2), atan(infinity), and what is left of these to pi
constexpr std::array<LongAngle, 4> kAngles{
    LongAngle{0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56}, LongAngle{0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
    LongAngle{0x1.f730bd281f69bp-1, 0x1.007887af0cbbdp-56}, LongAngle{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54}};
constexpr std::array<LongAngle, 4> kRests{
    LongAngle{0x1.56c6e7397f5aep+1, 0x1.660b64ece6f4bp-53}, LongAngle{0x1.2d97c7f3321d2p+1, 0x1.a79394c9e8a0ap-54},
    LongAngle{0x1.145385fa3af71p+1, 0x1.fa53523b6428fp-53}, LongAngle{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54}};

/// t - atan(t) for |t| < 7/16, by the polynomial of FDLIBM's s_atan.c (Sun Microsystems 1993: "Permission to use,
/// copy, modify, and distribute this software is freely granted, provided that this notice is preserved").
double belowArgument(double t) {
  const double z = t * t;
  const double w = z * z;
  const double odd = z * (3.33333333333329318027e-01 +
                          w * (1.42857142725034663711e-01 +
                               w * (9.09088713343650656196e-02 +
                                    w * (6.66107313738753120669e-02 +
                                         w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double even =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return t * (odd + even);
}

/// a - b c without rounding of the product (Dekker 1971). Their exponents are far from the ends of the range.
double remainderOf(double a, double b, double c) {
  constexpr double kSplit = 0x1p27 + 1.0;
  const double bHigh = b * kSplit - (b * kSplit - b);
  const double cHigh = c * kSplit - (c * kSplit - c);
  const double bLow = b - bHigh;
  const double cLow = c - cHigh;
  const double product = b * c;
  const double rest = bLow * cLow - (((product - bHigh * cHigh) - bLow * cHigh) - bHigh * cLow);
  return (a - product) - rest;
}

/// The angle of (x, y) in [0, pi] for y > 0 and |x| > 0 whose quotient and exponents are moderate.
double angleOf(double y, double x, bool isLeft) {
  // a small angle: the quotient with its remainder
  if (y < 0.4375 * x) {
    const double t = y / x;
    const double corrected = belowArgument(t) - remainderOf(y, t, x) / x;
    return isLeft ? kPi - ((t - corrected) - kPiRest) : t - corrected;
  }
  // else the difference to one of four angles; the numerators are exact
  std::size_t nearest = 3;
  double t = 0.0;
  if (y < 0.6875 * x) {
    nearest = 0;
    t = (2.0 * y - x) / (2.0 * x + y);
  } else if (y < 1.1875 * x) {
    nearest = 1;
    t = (y - x) / (x + y);
  } else if (y < 2.4375 * x) {
    nearest = 2;
    t = ((y - x) - 0.5 * x) / (x + 1.5 * y);
  } else {
    t = -x / y;
  }
  const double below = belowArgument(t);
  return isLeft ? kRests[nearest].hi + ((below + kRests[nearest].lo) - t)
                : kAngles[nearest].hi - ((below - kAngles[nearest].lo) - t);
}

/// The same for any y >= 0 and any x.
double upperAngle(double y, double x) {
  constexpr double kFar = 0x1p64;
  const bool isLeft = std::signbit(x);
  x = std::fabs(x);
  if (y == 0.0 || (std::isinf(x) && !std::isinf(y))) {
    return isLeft ? kPi : 0.0;
  }
  if (std::isinf(x)) {
    return isLeft ? 3.0 * kPi / 4.0 : kPi / 4.0;
  }
  if (x == 0.0 || y > kFar * x) {
    return kPi / 2.0;
  }
  if (x > kFar * y) {
    return isLeft ? kPi : y / x;
  }
  // products must neither overflow nor lose bits
  if (std::max(x, y) > 0x1p500 || std::min(x, y) < 0x1p-500) {
    const int exponent = std::ilogb(x);
    x = std::ldexp(x, -exponent);
    y = std::ldexp(y, -exponent);
  }
  return angleOf(y, x, isLeft);
}

/// The root of x^2 + y^2 for x >= y > 0 with moderate exponents. The error of the rounded root's square is taken off.
double correctedRoot(double x, double y) {
  const double root = std::sqrt(x * x + y * y);
  double excess = 0.0;
  if (root <= 2.0 * y) {
    const double rest = root - y;
    excess = x * (2.0 * rest - x) + (rest - 2.0 * (x - y)) * rest;
  } else {
    const double rest = root - x;
    excess = 2.0 * rest * (x - 2.0 * y) + ((4.0 * rest - y) * y + rest * rest);
  }
  return root - excess / (2.0 * root);
}

}  // namespace

double hypot(double x, double y) {
  constexpr double kFar = 0x1p60;
  if (std::isinf(x) || std::isinf(y)) {
    return std::numeric_limits<double>::infinity();
  }
  const double larger = std::max(std::fabs(x), std::fabs(y));
  const double smaller = std::min(std::fabs(x), std::fabs(y));
  if (std::isnan(x) || std::isnan(y) || smaller == 0.0 || larger > kFar * smaller) {
    return std::fabs(x) + std::fabs(y);
  }
  if (larger > 0x1p500) {
    return 0x1p600 * correctedRoot(0x1p-600 * larger, 0x1p-600 * smaller);
  }
  if (smaller < 0x1p-450) {
    return 0x1p-600 * correctedRoot(0x1p600 * larger, 0x1p600 * smaller);
  }
  return correctedRoot(larger, smaller);
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return std::copysign(upperAngle(std::fabs(y), x), y);
}

}  // namespace espalier::core
