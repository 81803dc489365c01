#include "engine/page/loopback_server_internal.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstring>

#include "engine/base/error.h"

namespace lithe {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostHead = 16 << 10, kMostBody = 64 << 10;  // bytes of a request
constexpr std::size_t kMostConnections = 64;
constexpr auto kPatience = std::chrono::seconds(15);  // with who does not finish asking, or does not read

std::string random_token() {
  unsigned char bytes[16];
  if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
    throw FileError("the system gives no random numbers", "getrandom", "see what forbids it: a sandbox?");
  std::string token;
  for (const unsigned char byte : bytes)
    for (const int digit : {byte >> 4, byte & 15}) token += "0123456789abcdef"[digit];
  return token;
}

/// In a time that does not tell how much of it was right.
bool is_same(std::string_view a, std::string_view b) {
  unsigned different = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    different |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return different == 0;
}

/// The field's values, one an occurrence; `name` in lower case.
std::vector<std::string> header(const std::string& head, const std::string& name) {
  std::vector<std::string> values;
  for (std::size_t line = head.find("\r\n"); line != std::string::npos; line = head.find("\r\n", line + 2)) {
    const std::size_t from = line + 2, colon = from + name.size();
    if (colon >= head.size() || head[colon] != ':' ||
        !std::equal(name.begin(), name.end(), head.begin() + static_cast<std::ptrdiff_t>(from),
                    [](char wanted, char c) { return wanted == (c >= 'A' && c <= 'Z' ? c + 32 : c); }))
      continue;
    const std::size_t end = std::min(head.find("\r\n", colon), head.size());
    const std::size_t first = std::min(head.find_first_not_of(" \t", colon + 1), end);
    values.push_back(head.substr(first, head.find_last_not_of(" \t", end - 1) + 1 - first));
  }
  return values;
}

std::string head_of(const HttpResponse& response) {
  const char* reason = response.status == 200 ? "OK" : response.status == 204 ? "No Content" : "Refused";
  std::string head =
      "HTTP/1.1 " + std::to_string(response.status) + " " + reason + "\r\nContent-Type: " + response.type +
      "\r\nConnection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
      "X-Frame-Options: DENY\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n"
      "Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
      "img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'\r\n";
  if (!response.more) head += "Content-Length: " + std::to_string(response.body.size()) + "\r\n";
  return head + "\r\n";
}

}  // namespace

struct LoopbackServer::Connection {
  int socket;
  std::string in{}, out{};
  std::size_t sent = 0;
  bool answered = false, left = false;
  std::function<bool(std::string& bytes)> more{};
  Clock::time_point moved = Clock::now();  // when bytes left last; before: when it came

  bool is_sent() const { return sent == out.size(); }
  /// Its last piece has gone: the next may be there.
  bool is_due() const { return more && is_sent() && !out.empty(); }
  /// Answered in full, or left.
  bool is_over() const { return left || (answered && is_sent() && !more); }
  void refill() {
    if (!more || !is_sent()) return;
    out.clear(), sent = 0;
    if (!more(out)) more = nullptr;
    if (!out.empty()) moved = Clock::now();  // patience counts from here
  }
  void send() {
    while (!left && !is_sent()) {
      const ssize_t count = ::send(socket, out.data() + sent, out.size() - sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0 && errno == EAGAIN) return;
      if (count <= 0) left = true;
      if (count > 0) sent += static_cast<std::size_t>(count), moved = Clock::now();
    }
  }
};

LoopbackServer::LoopbackServer(int port, Answer answer, const std::string& where)
    : answer_(std::move(answer)), token_(random_token()) {
  if (port < 0 || port > 65535)
    throw SceneError(std::to_string(port) + " is no port", where,
                     "give one of 1024 to 65535, or 0 for any that is free");
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  waker_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const int yes = 1;  // the port of a server that has just ended
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (listener_ < 0 || waker_ < 0 || ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, SOMAXCONN) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::string why = std::strerror(errno);
    ::close(listener_), ::close(waker_);
    throw FileError("port " + std::to_string(port) + " of 127.0.0.1 cannot be had: " + why, where,
                    "end the program that has it, give another port, or 0 for any that is free");
  }
  const std::string number = std::to_string(ntohs(address.sin_port));
  own_hosts_[0] = "127.0.0.1:" + number, own_hosts_[1] = "localhost:" + number;
  url_ = "http://" + own_hosts_[0] + "/" + token_ + "/";
  thread_ = std::thread([this] { serve(); });
}

LoopbackServer::~LoopbackServer() {
  ending_ = true;
  wake();
  thread_.join();
  ::close(listener_), ::close(waker_);
}

void LoopbackServer::wake() {
  if (woken_.exchange(true)) return;  // it has not looked yet
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(waker_, &one, sizeof one);  // full: it is awake already
}

void LoopbackServer::serve() {
  std::vector<Connection> connections;
  while (!ending_) {
    std::vector<pollfd> watched = {{waker_, POLLIN, 0}, {listener_, POLLIN, 0}};
    for (const Connection& c : connections) {
      const int wanted = (c.answered ? POLLRDHUP : POLLIN) | (c.is_sent() ? 0 : POLLOUT);
      watched.push_back({c.socket, static_cast<short>(wanted), 0});
    }
    const bool due =
        std::any_of(connections.begin(), connections.end(), [](const Connection& c) { return c.is_due(); });
    if (::poll(watched.data(), watched.size(), due ? 0 : 1000) < 0 && errno != EINTR) break;
    std::uint64_t woken;
    while (::read(waker_, &woken, sizeof woken) > 0) {
    }
    woken_ = false;
    for (std::size_t i = 0; i < connections.size(); ++i) {
      Connection& c = connections[i];
      const short happened = watched[i + 2].revents;
      if (!c.answered && happened != 0) read(c);
      if (c.answered && (happened & (POLLRDHUP | POLLHUP | POLLERR)) != 0) c.left = true;
      c.refill();
      c.send();
      const bool waits = c.more && c.is_sent();  // for news: that may take any time
      if (!waits && Clock::now() - c.moved > kPatience) c.left = true;
      if (c.is_over()) ::close(c.socket);
    }
    std::erase_if(connections, [](const Connection& c) { return c.is_over(); });
    accept_all(connections);
    streams_ = static_cast<int>(
        std::count_if(connections.begin(), connections.end(), [](const Connection& c) { return c.more != nullptr; }));
  }
  for (const Connection& c : connections) ::close(c.socket);
}

void LoopbackServer::accept_all(std::vector<Connection>& connections) const {
  for (int socket; (socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)) >= 0;) {
    if (connections.size() < kMostConnections)
      connections.push_back({socket});
    else
      ::close(socket);
  }
}

void LoopbackServer::read(Connection& c) const {
  char bytes[4096];
  const ssize_t count = ::recv(c.socket, bytes, sizeof bytes, 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    c.left = true;
    return;
  }
  c.in.append(bytes, static_cast<std::size_t>(count));
  const std::size_t end = c.in.find("\r\n\r\n");
  HttpResponse response{.status = 431, .body = "the request is too long\n"};
  if (std::min(end, c.in.size()) <= kMostHead) {
    if (end == std::string::npos) return;
    const std::string head = c.in.substr(0, end);
    const auto lengths = header(head, "content-length");
    std::size_t length = 0;
    if (!lengths.empty()) std::from_chars(lengths[0].data(), lengths[0].data() + lengths[0].size(), length);
    if (length <= kMostBody) {
      if (c.in.size() < end + 4 + length) return;
      HttpRequest request{.body = c.in.substr(end + 4, length)};
      response = response_to(head, request);
    }
  }
  c.answered = true;
  c.out = head_of(response) + response.body;
  c.more = std::move(response.more);
}

HttpResponse LoopbackServer::response_to(const std::string& head, HttpRequest& request) const {
  const auto hosts = header(head, "host"), origins = header(head, "origin");
  const auto is_own = [&](const std::string& host) { return host == own_hosts_[0] || host == own_hosts_[1]; };
  if (hosts.size() != 1 || !is_own(hosts[0])) return {.status = 403, .body = "this is another host\n"};
  if (!origins.empty() && (origins.size() > 1 || origins[0] != "http://" + hosts[0]))
    return {.status = 403, .body = "another page asks\n"};

  const std::size_t method = head.find(' '), target = head.find(' ', method + 1);
  if (target > head.find("\r\n")) return {.status = 400, .body = "this is no request of HTTP\n"};
  request.method = head.substr(0, method);
  request.path = head.substr(method + 1, target - method - 1);
  if (const std::size_t query = request.path.find('?'); query != std::string::npos) {
    request.query = request.path.substr(query + 1);
    request.path.resize(query);
  }
  const std::size_t slash = std::min(request.path.find('/', 1), request.path.size());
  if (!is_same(request.path.substr(0, slash), "/" + token_)) return {.status = 403, .body = "the token is missing\n"};
  request.path.erase(0, slash);
  if (request.method != "GET" && request.method != "POST") return {.status = 405, .body = "GET and POST are known\n"};
  return answer_(request);
}

}  // namespace lithe
