#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace lithe::test {

/// A browser's side of HTTP on 127.0.0.1, byte by byte: what it sends is what the test writes.
class HttpClient {
 public:
  explicit HttpClient(int port);
  ~HttpClient();
  HttpClient(HttpClient&& other) noexcept;
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  void send(const std::string& bytes) const;
  /// All so far, once the other side has ended, at least `wanted` bytes are there, or the time is over.
  const std::string& receive(std::size_t wanted = std::string::npos,
                             std::chrono::milliseconds patience = std::chrono::seconds(20));
  const std::string& received() const { return received_; }
  bool is_over() const { return over_; }

 private:
  int socket_;
  std::string received_;
  bool over_ = false;
};

/// "http://127.0.0.1:PORT/TOKEN/"
struct LiveAddress {
  int port;
  std::string path;  // "/TOKEN/"

  explicit LiveAddress(const std::string& url);
  std::string host() const { return "127.0.0.1:" + std::to_string(port); }
  /// The answer to a request as browsers make it, with its head.
  std::string get(const std::string& what) const;
  std::string post(const std::string& command) const;
};

/// What a page that follows a run receives.
class LiveFrames {
 public:
  /// Reads from frame 1 on, as a page does.
  explicit LiveFrames(const LiveAddress& address);

  /// Reads on until `enough` frames were read, the stream ended or the time is over.
  void read(std::size_t enough, std::chrono::milliseconds patience = std::chrono::seconds(20));
  bool is_over() const { return client_.is_over(); }

  std::vector<std::vector<double>> frames;  // those that a page has by now, but the first
  int thinned = 0;
  std::string status;  // JSON, the newest

 private:
  void take_messages();

  HttpClient client_;
  std::size_t at_ = 0;
};

}  // namespace lithe::test
