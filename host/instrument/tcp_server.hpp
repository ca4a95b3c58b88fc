// The controller's side of `tcp:HOST:PORT`, for an emulator.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace umov::instrument {

/// Serves one client at a time. A second one is sent `busy` with the name from the first one's
/// hello and disconnected. Not thread-safe; nothing but `wait` blocks.
class TcpServer {
 public:
  /// Listens on `address`:`port`; port 0 takes a free one. Throws umov::Error when it can't.
  explicit TcpServer(std::uint16_t port, const std::string& address = "127.0.0.1");
  ~TcpServer();
  TcpServer(TcpServer&&) noexcept;
  TcpServer& operator=(TcpServer&&) noexcept;

  /// The port listened on.
  std::uint16_t port() const;
  /// Accepts and refuses clients; waits up to `timeout` for bytes or a change. True when there are
  /// bytes to read or the client came or went.
  bool wait(std::chrono::microseconds timeout);
  bool has_client() const;
  /// Counts clients served; changes when one replaces another.
  std::uint64_t client_number() const;
  /// Reads what is there; 0 when nothing is or nobody is connected.
  std::size_t read(std::span<std::uint8_t> buffer);
  /// Returns how many bytes were taken, fewer than given when the client is slow: keep the rest.
  /// Takes and drops everything while nobody is connected, like a cable nobody is plugged into.
  std::size_t write(std::span<const std::uint8_t> bytes);

 private:
  struct Sockets;
  std::unique_ptr<Sockets> sockets_;
};

}  // namespace umov::instrument
