#include "tests/support/http_client.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

namespace lithe::test {

HttpClient::HttpClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0) << std::strerror(errno);
}

HttpClient::~HttpClient() {
  if (socket_ >= 0) ::close(socket_);
}

HttpClient::HttpClient(HttpClient&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), received_(std::move(other.received_)), over_(other.over_) {}

void HttpClient::send(const std::string& bytes) const {
  EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
}

const std::string& HttpClient::receive(std::size_t wanted, std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!over_ && received_.size() < wanted) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd watched{socket_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&watched, 1, static_cast<int>(left.count())) <= 0) break;
    char bytes[65536];
    const ssize_t count = ::recv(socket_, bytes, sizeof bytes, 0);
    if (count <= 0)
      over_ = true;
    else
      received_.append(bytes, static_cast<std::size_t>(count));
  }
  return received_;
}

LiveAddress::LiveAddress(const std::string& url) {
  const std::size_t colon = url.find(':', 7), slash = url.find('/', 7);
  port = std::stoi(url.substr(colon + 1));
  path = url.substr(slash);
}

std::string LiveAddress::get(const std::string& what) const {
  HttpClient client(port);
  client.send("GET " + path + what + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  return client.receive();
}

std::string LiveAddress::post(const std::string& command) const {
  HttpClient client(port);
  client.send("POST " + path + "command HTTP/1.1\r\nHost: " + host() + "\r\nOrigin: http://" + host() +
              "\r\nContent-Length: " + std::to_string(command.size()) + "\r\n\r\n" + command);
  return client.receive();
}

LiveFrames::LiveFrames(const LiveAddress& address) : client_(address.port) {
  client_.send("GET " + address.path + "frames?from=1 HTTP/1.1\r\nHost: " + address.host() + "\r\n\r\n");
  // With the head and a first message the server counts this reader.
  client_.receive(8);
  while (client_.received().find("\r\n\r\n") == std::string::npos && !client_.is_over())
    client_.receive(client_.received().size() + 1);
  at_ = client_.received().find("\r\n\r\n") + 4;
}

void LiveFrames::read(std::size_t enough, std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  take_messages();
  while (frames.size() < enough && !client_.is_over() && std::chrono::steady_clock::now() < end) {
    client_.receive(client_.received().size() + 1, std::chrono::milliseconds(20));
    take_messages();
  }
}

void LiveFrames::take_messages() {
  const std::string& bytes = client_.received();
  std::uint32_t head[2];
  while (at_ + sizeof head <= bytes.size()) {
    std::memcpy(head, bytes.data() + at_, sizeof head);
    const std::size_t from = at_ + sizeof head, size = head[1];
    if (from + size > bytes.size()) return;
    EXPECT_EQ(size % sizeof(double), 0u);
    if (head[0] == 1) {
      frames.emplace_back(size / sizeof(double));
      std::memcpy(frames.back().data(), bytes.data() + from, size);
    } else if (head[0] == 2) {  // the page's frames 0, 2, 4 … stay; 0 is not among these
      ++thinned;
      std::size_t kept = 0;
      for (std::size_t i = 1; i < frames.size(); i += 2) frames[kept++] = frames[i];
      frames.resize(kept);
    } else {
      EXPECT_EQ(head[0], 3u);
      status.assign(bytes, from, size);
    }
    at_ = from + size;
  }
}

}  // namespace lithe::test
