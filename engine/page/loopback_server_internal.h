#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace lithe {

struct HttpRequest {
  std::string method;  // GET or POST
  std::string path;    // behind the token, "/frames"
  std::string query;   // behind '?'
  std::string body;
};

struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
  /// Of a stream: appends what there is to send now, maybe nothing; false: that was all. Called by the server's thread
  /// when all before is sent, so that a slow reader has one piece waiting, never a queue.
  std::function<bool(std::string& bytes)> more{};
};

/// HTTP/1.1 for browsers of this machine: on 127.0.0.1 alone, by one thread of its own. A request is answered when it
/// knows the token, 128 random bits of the system in the address, and comes from the server's own address: other pages
/// can neither read nor post here, not even under a name that resolves to 127.0.0.1 (DNS rebinding).
class LoopbackServer {
 public:
  using Answer = std::function<HttpResponse(const HttpRequest&)>;

  /// Port 0: a free one. `answer` is called by the server's thread and must not throw. Throws FileError for a port
  /// that is in use or not allowed, SceneError for a number that is no port.
  LoopbackServer(int port, Answer answer, const std::string& where);
  /// Ends connections where they are.
  ~LoopbackServer();
  LoopbackServer(const LoopbackServer&) = delete;
  LoopbackServer& operator=(const LoopbackServer&) = delete;

  /// "http://127.0.0.1:PORT/TOKEN/"
  const std::string& url() const { return url_; }
  /// Asks streams for more. Any thread may call it.
  void wake();
  /// Those that somebody reads.
  int stream_count() const { return streams_; }

 private:
  struct Connection;

  void serve();
  void accept_all(std::vector<Connection>& connections) const;
  void read(Connection& connection) const;
  HttpResponse response_to(const std::string& head, HttpRequest& request) const;

  const Answer answer_;
  int listener_ = -1, waker_ = -1;
  std::string token_, own_hosts_[2], url_;
  std::atomic<bool> ending_ = false, woken_ = false;
  std::atomic<int> streams_ = 0;
  std::thread thread_;
};

}  // namespace lithe
