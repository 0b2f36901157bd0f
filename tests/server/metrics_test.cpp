#include "server/metrics.h"

#include <gtest/gtest.h>

namespace espalier::server::metrics_test {
namespace {

TEST(Metrics, HistogramsAreCumulativeAndEndWithTheirSumAndCount) {
  DurationHistogram histogram;
  histogram.observe(0.0001);  // on a bound: belongs to it
  histogram.observe(0.0002);
  histogram.observe(100.0);
  std::string text;
  histogram.appendTo(text, "x");
  EXPECT_EQ(text.find("x_bucket{le=\"1e-04\"} 1\nx_bucket{le=\"0.00025\"} 2\n"), 0U) << text;
  EXPECT_NE(text.find("x_bucket{le=\"30\"} 2\nx_bucket{le=\"+Inf\"} 3\nx_sum 100.0003\nx_count 3\n"), std::string::npos)
      << text;
}

TEST(Metrics, EveryFamilyHasHelpAndType) {
  Metrics metrics;
  metrics.steps = 5;
  metrics.drops = 2;
  const std::string text = prometheusText(metrics, {.sessions = 3, .simulations = 4, .workers = 2, .residentBytes = 9});
  EXPECT_NE(text.find("# TYPE espalier_steps_total counter\nespalier_steps_total 5\n"), std::string::npos) << text;
  EXPECT_NE(text.find("# TYPE espalier_stream_drops_total counter\nespalier_stream_drops_total 2\n"),
            std::string::npos);
  EXPECT_NE(text.find("# TYPE espalier_sessions gauge\nespalier_sessions 3\n"), std::string::npos);
  EXPECT_NE(text.find("# TYPE espalier_environment_seconds histogram\n"), std::string::npos);
  EXPECT_GT(residentBytes(), 1'000'000U);
}

TEST(Metrics, EveryGaugeHasAFamilyOfItsOwn) {
  const std::string text = prometheusText(Metrics(), {.sessions = 11,
                                                      .simulations = 12,
                                                      .workers = 13,
                                                      .residentBytes = 14,
                                                      .stringBytes = 15,
                                                      .streamBytes = 16,
                                                      .outboxBytes = 17,
                                                      .decodingBytes = 19,
                                                      .storeBytes = 18,
                                                      .traceBytes = 21,
                                                      .databaseBytes = 22});
  for (const std::string_view line :
       {"espalier_sessions 11", "espalier_simulations 12", "espalier_workers 13", "espalier_resident_bytes 14",
        "espalier_string_bytes 15", "espalier_stream_bytes 16", "espalier_outbox_bytes 17", "espalier_store_bytes 18",
        "espalier_decoding_bytes 19", "espalier_trace_bytes 21", "espalier_database_memory_bytes 22"}) {
    const std::string name(line.substr(0, line.find(' ')));
    EXPECT_NE(text.find("# TYPE " + name + " gauge\n" + std::string(line) + "\n"), std::string::npos) << line << "\n"
                                                                                                      << text;
    EXPECT_NE(text.find("# HELP " + name + " "), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace espalier::server::metrics_test
