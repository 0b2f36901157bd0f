#include "environment/published/text_coupling.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/turtle/field.h"
#include "environment/base/float_number.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kFlags = "-+ #0";
constexpr std::string_view kDigits = "0123456789";
constexpr std::size_t kMostDigits = 3;  // digits of a width or a precision

class TextCoupling final : public turtle::EnvironmentProcess {
 public:
  TextCoupling(std::unique_ptr<turtle::EnvironmentProcess> process, TurtleFormats formats)
      : process_(std::move(process)), formats_(std::move(formats)), needs_(process_->describe().needs) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    // items that are not sent need not be filled in
    turtle::EnvironmentDescription description = process_->describe();
    turtle::EnvironmentNeeds& needs = description.needs;
    needs.position = needs.position && formats_.position;
    needs.heading = needs.heading && formats_.heading;
    needs.left = needs.left && formats_.left;
    needs.up = needs.up && formats_.up;
    needs.width = needs.width && formats_.width;
    needs.scale = needs.scale && formats_.scale;
    needs.following = needs.following && formats_.isFollowingSent;
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    auto error = process_->open(context);
    needs_ = process_->describe().needs;
    return error;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    sent_ = queries;
    for (double& parameter : sent_.parameters) {
      parameter = toFloat(core::roundThroughPercentG(parameter));
    }
    exchange(needs_.position, formats_.position, queries.position, sent_.position);
    exchange(needs_.heading, formats_.heading, queries.heading, sent_.heading);
    exchange(needs_.left, formats_.left, queries.left, sent_.left);
    exchange(needs_.up, formats_.up, queries.up, sent_.up);
    exchange(needs_.width, formats_.width, queries.width, sent_.width);
    exchange(needs_.scale, formats_.scale, queries.scale, sent_.scale);
    exchangeFollowing();
    if (auto error = process_->step(sent_, replies)) {
      return error;
    }
    for (double& value : replies.values) {
      value = core::roundThroughPercentG(toFloat(value));
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override { return std::nullopt; }
  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return process_->restore(state);
  }

 private:
  void exchange(bool isNeeded, const std::optional<TurtleFormat>& format, const std::vector<core::Vec3>& items,
                std::vector<core::Vec3>& arrived) const {
    arrived.assign(isNeeded ? sent_.size() : 0, core::Vec3{});
    if (isNeeded && format) {
      std::transform(items.begin(), items.end(), arrived.begin(),
                     [&](const core::Vec3& item) { return format->exchanged(item); });
    }
  }

  void exchange(bool isNeeded, const std::optional<TurtleFormat>& format, const std::vector<double>& items,
                std::vector<double>& arrived) const {
    arrived.assign(isNeeded ? sent_.size() : 0, 0.0);
    if (isNeeded && format) {
      std::transform(items.begin(), items.end(), arrived.begin(),
                     [&](double item) { return format->exchanged(0, item); });
    }
  }

  void exchangeFollowing() {
    if (formats_.isFollowingSent) {
      for (double& parameter : sent_.followingParameters) {
        parameter = toFloat(core::roundThroughPercentG(parameter));
      }
    } else if (needs_.following) {
      sent_.following.assign(sent_.size(), core::kNoSymbol);
      sent_.followingOffset.assign(sent_.size() + 1, 0);
      sent_.followingParameters.clear();
    }
  }

  std::unique_ptr<turtle::EnvironmentProcess> process_;
  TurtleFormats formats_;
  turtle::EnvironmentNeeds needs_;  // of the wrapped process
  turtle::QueryBatch sent_;         // the queries of a step as they arrive
};

/// Length of the run of `characters` at the beginning of a text.
std::size_t spanOf(std::string_view text, std::string_view characters) {
  return std::min(text.find_first_not_of(characters), text.size());
}

}  // namespace

tl::expected<TurtleFormat, std::string> TurtleFormat::parse(std::string_view format, std::size_t maximumCount) {
  TurtleFormat result;
  for (std::size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '%') {
      continue;
    }
    if (i + 1 < format.size() && format[i + 1] == '%') {
      ++i;
      continue;
    }
    std::size_t end = i + 1;
    end += spanOf(format.substr(end), kFlags);
    const std::size_t width = spanOf(format.substr(end), kDigits);
    end += width;
    std::size_t precision = 0;
    if (end < format.size() && format[end] == '.') {
      precision = spanOf(format.substr(end + 1), kDigits);
      end += 1 + precision;
    }
    const std::string before(format.substr(i, end - i));
    if (end < format.size() && format[end] == 'l') {
      ++end;
    }
    if (end >= format.size() || std::string_view("fFeEgG").find(format[end]) == std::string_view::npos) {
      return tl::unexpected("the conversion '" + std::string(format.substr(i, end + 1 - i)) +
                            "' does not print a real number; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
    }
    if (width > kMostDigits || precision > kMostDigits) {
      return tl::unexpected("the conversion '" + std::string(format.substr(i, end + 1 - i)) +
                            "' is wider than 999 characters");
    }
    if (result.conversions_.size() < maximumCount) {
      result.conversions_.push_back(before + format[end]);
    }
    i = end;
  }
  if (result.conversions_.empty()) {
    return tl::unexpected(std::string("the format has no conversion; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'"));
  }
  return result;
}

double TurtleFormat::exchanged(std::size_t k, double value) const {
  if (k >= conversions_.size()) {
    return 0.0;
  }
  // the formats were checked by parse(): one floating-point conversion each
  std::array<char, 1600> text{};
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  const int length =
      std::snprintf(text.data(), text.size(), conversions_[k].c_str(), static_cast<double>(toFloat(value)));
#pragma GCC diagnostic pop
  std::string_view printed(text.data(), static_cast<std::size_t>(std::clamp(length, 0, 1599)));
  const std::size_t begin = printed.find_first_not_of(" +");
  const std::size_t end = printed.find_last_not_of(' ');
  if (begin == std::string_view::npos) {
    return 0.0;
  }
  return toFloat(core::parseNumber(printed.substr(begin, end + 1 - begin)).value_or(value));
}

core::Vec3 TurtleFormat::exchanged(const core::Vec3& vector) const {
  return {exchanged(0, vector.x), exchanged(1, vector.y), exchanged(2, vector.z)};
}

std::unique_ptr<turtle::EnvironmentProcess> makeTextCoupling(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                             TurtleFormats formats) {
  return std::make_unique<TextCoupling>(std::move(process), std::move(formats));
}

}  // namespace espalier::environment
