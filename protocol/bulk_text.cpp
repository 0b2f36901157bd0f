#include "protocol/bulk_text.h"

#include <simdjson.h>
#include <array>
#include <charconv>
#include <cmath>

#include "protocol/decoding/column_storage.h"
#include "protocol/decoding/payload_content.h"
#include "protocol/version.h"

namespace espalier::protocol {
namespace {

namespace ondemand = simdjson::ondemand;

/// Thrown about a line that decodeMessage shall read or report.
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

/// The name of a member. Names of the protocol have no escapes: a name with one equals none of them.
std::string_view nameOf(ondemand::field& member) {
  const char* begin = member.key().raw();
  const char* end = begin;
  while (*end != '"') {
    end += *end == '\\' ? 2 : 1;
  }
  return {begin, static_cast<std::size_t>(end - begin)};
}

/// How a Reader takes one member of its object.
template <typename Reader>
struct MemberRow {
  std::string_view name;
  bool isRequired;
  void (Reader::*read)(ondemand::value);
};

/// Gives each member to its function. Unusual: a member that is not in the table or comes twice, or a required one that
/// is missing.
template <typename Reader, std::size_t count>
void readMembers(ondemand::object object, Reader& reader, const std::array<MemberRow<Reader>, count>& rows) {
  std::array<bool, count> isSeen{};
  for (auto entry : object) {
    ondemand::field member = must(std::move(entry));
    const std::string_view name = nameOf(member);
    std::size_t i = 0;
    while (i < count && rows[i].name != name) {
      ++i;
    }
    require(i < count && !isSeen[i]);
    isSeen[i] = true;
    (reader.*rows[i].read)(member.value());
  }
  for (std::size_t i = 0; i < count; ++i) {
    require(isSeen[i] || !rows[i].isRequired);
  }
}

// simdjson 3.0 reads a double wrongly, and silently, when it has more digits than a 64-bit integer holds
constexpr std::size_t kSafeDigits = 18;

double numberOf(ondemand::value value) {
  std::string_view token = value.raw_json_token();
  double number = must(value.get_double());
  if (token.size() > kSafeDigits) {
    // the token ends with spaces or the next bracket: cut it after the last digit
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

template <typename Read>
void eachElement(ondemand::value value, Read&& read) {
  for (auto element : must(value.get_array())) {
    read(must(std::move(element)));
  }
}

/// The next module of a query.
class FollowingReader {
 public:
  explicit FollowingReader(QueryCollector& queries) : queries_(queries) {}
  void read(ondemand::value value) {
    using Row = MemberRow<FollowingReader>;
    static constexpr std::array kRows{Row{"symbol", true, &FollowingReader::symbol},
                                      Row{"parameters", false, &FollowingReader::parameters}};
    readMembers(must(value.get_object()), *this, kRows);
  }

 private:
  void symbol(ondemand::value value) {
    queries_.following(must(value.get_string()));
    hasSymbol_ = true;
  }
  void parameters(ondemand::value value) {
    require(hasSymbol_);
    eachNumber(value, [&](double number) { queries_.followingParameter(number); });
  }

  QueryCollector& queries_;
  bool hasSymbol_ = false;
};

/// One query. The members that name it come before the numbers, as every known writer has them.
class QueryReader {
 public:
  explicit QueryReader(QueryCollector& queries) : queries_(queries) {}
  void read(ondemand::value value) {
    using Row = MemberRow<QueryReader>;
    static constexpr std::array kRows{
        Row{"id", true, &QueryReader::id},
        Row{"plant", false, &QueryReader::plant},
        Row{"module", false, &QueryReader::module},
        Row{"transient", false, &QueryReader::transient},
        Row{"symbol", true, &QueryReader::symbol},
        Row{"parameters", false, &QueryReader::parameters},
        Row{"position", false, &QueryReader::vector<&QueryCollector::position>},
        Row{"heading", false, &QueryReader::vector<&QueryCollector::heading>},
        Row{"left", false, &QueryReader::vector<&QueryCollector::left>},
        Row{"up", false, &QueryReader::vector<&QueryCollector::up>},
        Row{"width", false, &QueryReader::number<&QueryCollector::width>},
        Row{"scale", false, &QueryReader::number<&QueryCollector::scale>},
        Row{"following", false, &QueryReader::following},
    };
    readMembers(must(value.get_object()), *this, kRows);
    queries_.endParameters();
  }

 private:
  void id(ondemand::value value) {
    require(!isBegun_ && countOf(value, kMaximumExactInteger) == queries_.count());
    hasId_ = true;
  }
  void plant(ondemand::value value) {
    require(!isBegun_);
    plant_ = static_cast<std::uint32_t>(countOf(value, 0xFFFFFFFF));
  }
  void module(ondemand::value value) {
    require(!isBegun_);
    module_ = countOf(value, kMaximumExactInteger);
  }
  void transient(ondemand::value value) {
    require(!isBegun_);
    isTransient_ = must(value.get_bool());
  }
  void symbol(ondemand::value value) {
    require(hasId_);
    queries_.begin(plant_, module_, isTransient_, must(value.get_string()));
    isBegun_ = true;
  }
  void parameters(ondemand::value value) {
    require(isBegun_);
    eachNumber(value, [&](double number) { queries_.parameter(number); });
  }
  template <auto add>
  void vector(ondemand::value value) {
    require(isBegun_);
    (queries_.*add)(vectorOf(value));
  }
  template <auto add>
  void number(ondemand::value value) {
    require(isBegun_);
    (queries_.*add)(numberOf(value));
  }
  void following(ondemand::value value) {
    require(isBegun_);
    FollowingReader(queries_).read(value);
  }

  QueryCollector& queries_;
  std::uint32_t plant_ = 0;
  std::uint64_t module_ = 0;
  bool isTransient_ = false;
  bool hasId_ = false;
  bool isBegun_ = false;  // in the collector
};

/// The params of environment.step.
class StepReader {
 public:
  explicit StepReader(EnvironmentStepParams& step) : step_(step) {}
  void read(ondemand::value value) {
    using Row = MemberRow<StepReader>;
    static constexpr std::array kRows{
        Row{"simulation", true, &StepReader::simulation}, Row{"step", true, &StepReader::step},
        Row{"iteration", false, &StepReader::iteration}, Row{"time", false, &StepReader::time},
        Row{"queries", true, &StepReader::queries}};
    readMembers(must(value.get_object()), *this, kRows);
  }

 private:
  void simulation(ondemand::value value) { step_.simulation = std::string(must(value.get_string())); }
  void step(ondemand::value value) { step_.step = countOf(value, kMaximumExactInteger); }
  void iteration(ondemand::value value) { step_.iteration = static_cast<std::uint32_t>(countOf(value, 0xFFFFFFFF)); }
  void time(ondemand::value value) { step_.timeDays = numberOf(value); }
  void queries(ondemand::value value) {
    QueryCollector queries;
    eachElement(value, [&](ondemand::value query) { QueryReader(queries).read(query); });
    step_.queries = queries.take();
  }

  EnvironmentStepParams& step_;
};

/// One reply. Its id comes first.
class ReplyReader {
 public:
  explicit ReplyReader(ReplyCollector& replies) : replies_(replies) {}
  void read(ondemand::value value) {
    using Row = MemberRow<ReplyReader>;
    static constexpr std::array kRows{Row{"id", true, &ReplyReader::id},
                                      Row{"parameters", false, &ReplyReader::parameters}};
    readMembers(must(value.get_object()), *this, kRows);
    replies_.end();
  }

 private:
  void id(ondemand::value value) {
    replies_.begin(static_cast<std::uint32_t>(countOf(value, 0xFFFFFFFF)));
    hasId_ = true;
  }
  void parameters(ondemand::value value) {
    require(hasId_);
    eachElement(value, [&](ondemand::value number) {
      if (must(number.is_null())) {
        replies_.keep();
      } else {
        replies_.value(numberOf(number));
      }
    });
  }

  ReplyCollector& replies_;
  bool hasId_ = false;
};

/// The result of environment.step.
class RepliesReader {
 public:
  ReplyColumns read(ondemand::value value) {
    using Row = MemberRow<RepliesReader>;
    static constexpr std::array kRows{Row{"replies", true, &RepliesReader::replies},
                                      Row{"notes", false, &RepliesReader::notes}};
    readMembers(must(value.get_object()), *this, kRows);
    ReplyColumns columns = replies_.take();
    columns.notes = std::move(notes_);
    return columns;
  }

 private:
  void replies(ondemand::value value) {
    eachElement(value, [&](ondemand::value reply) { ReplyReader(replies_).read(reply); });
  }
  void notes(ondemand::value value) {
    eachElement(value, [&](ondemand::value note) { addNote(must(note.get_string()), notes_); });
  }

  ReplyCollector replies_;
  std::vector<std::string> notes_;
};

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

/// The whole message.
class EnvelopeReader {
 public:
  EnvelopeReader(ondemand::document& document, BulkText& bulk) : document_(document), bulk_(bulk) {}

  Message read() {
    using Row = MemberRow<EnvelopeReader>;
    static constexpr std::array kRows{
        Row{"jsonrpc", true, &EnvelopeReader::version}, Row{"id", true, &EnvelopeReader::id},
        Row{"method", false, &EnvelopeReader::method}, Row{"params", false, &EnvelopeReader::params},
        Row{"result", false, &EnvelopeReader::result}};
    readMembers(must(document_.get_object()), *this, kRows);
    const char* rest = nullptr;
    require(document_.current_location().get(rest) == simdjson::OUT_OF_BOUNDS);
    require(bulk_.replies.has_value() != bulk_.step.has_value() && message_.method.empty() != bulk_.step.has_value());
    // up to the bracket that closes it
    bulk_.json = bulk_.json.substr(0, bulk_.json.rfind('}', bulk_.json.size()) + 1);
    message_.kind = bulk_.step ? Message::Kind::Request : Message::Kind::Result;
    return std::move(message_);
  }

 private:
  void version(ondemand::value value) { require(must(value.get_string()) == "2.0"); }
  void id(ondemand::value value) { message_.id = idOf(value); }
  void method(ondemand::value value) {
    message_.method = std::string(must(value.get_string()));
    require(message_.method == "environment.step");
  }
  void params(ondemand::value value) {
    require(!message_.method.empty());
    const char* const begin = value.raw_json_token().data();
    StepReader(bulk_.step.emplace()).read(value);
    noteText(begin);
  }
  void result(ondemand::value value) {
    const char* const begin = value.raw_json_token().data();
    bulk_.replies = RepliesReader().read(value);
    noteText(begin);
  }
  /// Notes where the value lies that was just read.
  void noteText(const char* begin) {
    const char* end = nullptr;
    require(document_.current_location().get(end) == simdjson::SUCCESS);
    bulk_.json = {begin, static_cast<std::size_t>(end - begin)};
  }

  ondemand::document& document_;
  BulkText& bulk_;
  Message message_;
};

}  // namespace

struct BulkTextReader::Parser {
  ondemand::parser parser;
};

BulkTextReader::BulkTextReader() = default;
BulkTextReader::~BulkTextReader() = default;
BulkTextReader::BulkTextReader(BulkTextReader&&) noexcept = default;
BulkTextReader& BulkTextReader::operator=(BulkTextReader&&) noexcept = default;

std::optional<Message> BulkTextReader::read(std::string_view line) {
  // only two messages can be big
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
    Message message = EnvelopeReader(document, *bulk).read();
    bulk->owner = std::move(text);
    const char* const name = bulk->step ? "params" : "result";
    message.payload = Payload(std::move(bulk), name);
    return message;
  } catch (const Unusual&) {
    return std::nullopt;
  }
}

void BulkTextReader::rest() {
  parser_.reset();
}

}  // namespace espalier::protocol
