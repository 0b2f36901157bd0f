#pragma once

#include <boost/asio.hpp>
#include <string>
#include <thread>
#include <vector>

namespace espalier::client {

/// A server that sends one prepared text for every line it receives, then closes.
class ScriptedServer {
 public:
  explicit ScriptedServer(std::vector<std::string> answers)
      : acceptor_(context_, boost::asio::ip::tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0)) {
    port_ = acceptor_.local_endpoint().port();
    thread_ = std::thread([this, answers = std::move(answers)] {
      boost::asio::ip::tcp::socket socket = acceptor_.accept();
      boost::asio::streambuf buffer;
      for (const std::string& answer : answers) {
        boost::system::error_code error;
        const std::size_t count = boost::asio::read_until(socket, buffer, '\n', error);
        if (error) {
          return;
        }
        buffer.consume(count);
        boost::asio::write(socket, boost::asio::buffer(answer), error);
      }
    });
  }
  ~ScriptedServer() { thread_.join(); }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::acceptor acceptor_;
  unsigned short port_ = 0;
  std::thread thread_;
};

/// The answer to hello.
inline const std::string kWelcome = "{\"jsonrpc\":\"2.0\",\"id\":1,\"result\":{\"protocol\":1}}\n";

}  // namespace espalier::client
