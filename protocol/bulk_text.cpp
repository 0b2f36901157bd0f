#include "protocol/bulk_text.h"

#include <simdjson.h>
#include <charconv>
#include <cmath>

#include "protocol/column_storage.h"
#include "protocol/version.h"

namespace espalier::protocol {
namespace {

namespace ondemand = simdjson::ondemand;

/// Something that the tree reads, or reports, better.
struct Unusual {};

template <typename T>
T must(simdjson::simdjson_result<T>&& result) {
  T value{};
  if (std::move(result).get(value) != simdjson::SUCCESS) {
    throw Unusual{};
  }
  return value;
}

void require(bool isUsual) {
  if (!isUsual) {
    throw Unusual{};
  }
}

/// A bit for each member of an object that was seen: members that come twice are unusual.
class Seen {
 public:
  void once(unsigned bit) {
    require((bits_ & (1U << bit)) == 0);
    bits_ |= 1U << bit;
  }
  [[nodiscard]] bool has(unsigned bit) const { return (bits_ & (1U << bit)) != 0; }

 private:
  unsigned bits_ = 0;
};

std::string_view keyOf(ondemand::field& field) {
  const ondemand::raw_json_string raw = field.key();
  // names of the protocol have no escapes: a name with one equals none of them
  const char* begin = raw.raw();
  const char* end = begin;
  while (*end != '"') {
    end += *end == '\\' ? 2 : 1;
  }
  return {begin, static_cast<std::size_t>(end - begin)};
}

// simdjson 3.0 reads doubles of more digits than a 64-bit integer holds wrongly, without a word
constexpr std::size_t kSafeDigits = 18;

double numberOf(ondemand::value value) {
  std::string_view token = value.raw_json_token();
  double number = must(value.get_double());
  if (token.size() > kSafeDigits) {
    // what it took for a number is one
    while (!token.empty() && (token.back() < '0' || token.back() > '9')) {
      token.remove_suffix(1);
    }
    const auto read = std::from_chars(token.data(), token.data() + token.size(), number);
    require(read.ec == std::errc() && read.ptr == token.data() + token.size());
  }
  require(std::isfinite(number));
  if (number == 0.0 && std::signbit(number)) {
    // -0 is the integer 0, -0.0 is not
    for (const char c : token) {
      if (c == '.' || c == 'e' || c == 'E') {
        return number;
      }
    }
    return 0.0;
  }
  return number;
}

std::uint64_t countOf(ondemand::value value, std::uint64_t most) {
  const std::uint64_t number = must(value.get_uint64());
  require(number <= most);
  return number;
}

std::array<double, 3> vectorOf(ondemand::value value) {
  std::array<double, 3> v{};
  std::size_t count = 0;
  for (auto element : must(value.get_array())) {
    require(count < 3);
    v[count++] = numberOf(must(std::move(element)));
  }
  require(count == 3);
  return v;
}

template <typename Add>
void eachNumber(ondemand::value value, Add&& add) {
  for (auto element : must(value.get_array())) {
    add(numberOf(must(std::move(element))));
  }
}

void readFollowing(ondemand::value value, QueryCollector& queries) {
  Seen seen;
  for (auto entry : must(value.get_object())) {
    ondemand::field field = must(std::move(entry));
    const std::string_view key = keyOf(field);
    if (key == "symbol") {
      seen.once(0);
      queries.following(must(field.value().get_string()));
    } else if (key == "parameters") {
      seen.once(1);
      require(seen.has(0));
      eachNumber(field.value(), [&](double number) { queries.followingParameter(number); });
    } else {
      throw Unusual{};
    }
  }
  require(seen.has(0));
}

/// One query. The members that name it come before the numbers, as every writer so far has them.
void readQuery(ondemand::value value, QueryCollector& queries) {
  Seen seen;
  std::uint64_t id = 0;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  bool isTransient = false;
  for (auto entry : must(value.get_object())) {
    ondemand::field field = must(std::move(entry));
    const std::string_view key = keyOf(field);
    ondemand::value member = field.value();
    if (key == "id") {
      seen.once(0);
      id = countOf(member, kMaximumExactInteger);
    } else if (key == "plant") {
      seen.once(1);
      plant = static_cast<std::uint32_t>(countOf(member, 0xFFFFFFFF));
    } else if (key == "module") {
      seen.once(2);
      module = countOf(member, kMaximumExactInteger);
    } else if (key == "transient") {
      seen.once(3);
      isTransient = must(member.get_bool());
    } else if (key == "symbol") {
      seen.once(4);
      require(seen.has(0) && id == queries.count());
      queries.begin(plant, module, isTransient, must(member.get_string()));
    } else {
      require(seen.has(4));
      if (key == "parameters") {
        seen.once(5);
        eachNumber(member, [&](double number) { queries.parameter(number); });
      } else if (key == "position") {
        seen.once(6);
        queries.position(vectorOf(member));
      } else if (key == "heading") {
        seen.once(7);
        queries.heading(vectorOf(member));
      } else if (key == "left") {
        seen.once(8);
        queries.left(vectorOf(member));
      } else if (key == "up") {
        seen.once(9);
        queries.up(vectorOf(member));
      } else if (key == "width") {
        seen.once(10);
        queries.width(numberOf(member));
      } else if (key == "scale") {
        seen.once(11);
        queries.scale(numberOf(member));
      } else if (key == "following") {
        seen.once(12);
        readFollowing(member, queries);
      } else {
        throw Unusual{};
      }
    }
    // what names a query after it was begun
    require(!(seen.has(4) && (key == "id" || key == "plant" || key == "module" || key == "transient")));
  }
  require(seen.has(4));
  queries.endParameters();
}

void readStep(ondemand::value value, EnvironmentStepParams& step) {
  Seen seen;
  for (auto entry : must(value.get_object())) {
    ondemand::field field = must(std::move(entry));
    const std::string_view key = keyOf(field);
    ondemand::value member = field.value();
    if (key == "simulation") {
      seen.once(0);
      step.simulation = std::string(must(member.get_string()));
    } else if (key == "step") {
      seen.once(1);
      step.step = countOf(member, kMaximumExactInteger);
    } else if (key == "iteration") {
      seen.once(2);
      step.iteration = static_cast<std::uint32_t>(countOf(member, 0xFFFFFFFF));
    } else if (key == "time") {
      seen.once(3);
      step.timeDays = numberOf(member);
    } else if (key == "queries") {
      seen.once(4);
      QueryCollector queries;
      for (auto element : must(member.get_array())) {
        readQuery(must(std::move(element)), queries);
      }
      step.queries = queries.take();
    } else {
      throw Unusual{};
    }
  }
  require(seen.has(0) && seen.has(1) && seen.has(4));
}

void readReply(ondemand::value value, ReplyCollector& replies) {
  Seen seen;
  for (auto entry : must(value.get_object())) {
    ondemand::field field = must(std::move(entry));
    const std::string_view key = keyOf(field);
    ondemand::value member = field.value();
    if (key == "id") {
      seen.once(0);
      replies.begin(static_cast<std::uint32_t>(countOf(member, 0xFFFFFFFF)));
    } else if (key == "parameters") {
      seen.once(1);
      require(seen.has(0));
      for (auto element : must(member.get_array())) {
        ondemand::value number = must(std::move(element));
        if (must(number.is_null())) {
          replies.keep();
        } else {
          replies.value(numberOf(number));
        }
      }
    } else {
      throw Unusual{};
    }
  }
  require(seen.has(0));
  replies.end();
}

ReplyColumns readReplies(ondemand::value value) {
  Seen seen;
  ReplyCollector replies;
  for (auto entry : must(value.get_object())) {
    ondemand::field field = must(std::move(entry));
    require(keyOf(field) == "replies");
    seen.once(0);
    for (auto element : must(field.value().get_array())) {
      readReply(must(std::move(element)), replies);
    }
  }
  require(seen.has(0));
  return replies.take();
}

MessageId idOf(ondemand::value value) {
  if (must(value.type()) == ondemand::json_type::string) {
    const std::string_view text = must(value.get_string());
    require(text.size() <= 200);
    return MessageId::of(std::string(text));
  }
  const std::int64_t number = must(value.get_int64());
  require(number >= -kMaximumExactInteger && number <= kMaximumExactInteger);
  return MessageId::of(number);
}

}  // namespace

struct BulkTextReader::Parser {
  ondemand::parser parser;
};

BulkTextReader::BulkTextReader() = default;
BulkTextReader::~BulkTextReader() = default;
BulkTextReader::BulkTextReader(BulkTextReader&&) noexcept = default;
BulkTextReader& BulkTextReader::operator=(BulkTextReader&&) noexcept = default;

std::optional<Message> BulkTextReader::read(std::string_view line) {
  // only the two messages that can be big are worth looking at
  const std::string_view start = line.substr(0, 400);
  const bool isStep = start.find("\"environment.step\"") != std::string_view::npos;
  if (!isStep && start.find("\"replies\"") == std::string_view::npos) {
    return std::nullopt;
  }
  if (parser_ == nullptr) {
    parser_ = std::make_unique<Parser>();
  }
  try {
    auto text = std::make_shared<const simdjson::padded_string>(line);
    ondemand::document document = must(parser_->parser.iterate(*text));
    auto bulk = std::make_shared<BulkText>();
    Message message;
    Seen seen;
    std::string_view name;
    for (auto entry : must(document.get_object())) {
      ondemand::field field = must(std::move(entry));
      const std::string_view key = keyOf(field);
      ondemand::value member = field.value();
      if (key == "jsonrpc") {
        seen.once(0);
        require(must(member.get_string()) == "2.0");
      } else if (key == "id") {
        seen.once(1);
        message.id = idOf(member);
      } else if (key == "method") {
        seen.once(2);
        message.method = std::string(must(member.get_string()));
        require(message.method == "environment.step");
      } else if (key == "params" || key == "result") {
        // where the value lies in the text
        const char* begin = member.raw_json_token().data();
        seen.once(3);
        name = key;
        if (key == "params") {
          require(seen.has(2));
          bulk->step.emplace();
          readStep(member, *bulk->step);
        } else {
          bulk->replies = readReplies(member);
        }
        const char* end = nullptr;
        require(document.current_location().get(end) == simdjson::SUCCESS);
        bulk->json = {begin, static_cast<std::size_t>(end - begin)};
      } else {
        throw Unusual{};
      }
    }
    const char* rest = nullptr;
    require(document.current_location().get(rest) == simdjson::OUT_OF_BOUNDS && seen.has(0) && seen.has(1) &&
            seen.has(3) && seen.has(2) == bulk->step.has_value());
    // up to the bracket that closes it
    bulk->json = bulk->json.substr(0, bulk->json.rfind('}', bulk->json.size()) + 1);
    bulk->owner = std::move(text);
    message.kind = bulk->step ? Message::Kind::Request : Message::Kind::Result;
    message.payload = Payload(std::move(bulk), std::string(name));
    return message;
  } catch (const Unusual&) {
    return std::nullopt;
  }
}

}  // namespace espalier::protocol
