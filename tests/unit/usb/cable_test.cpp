// USB/IP: what a kernel at the other end of the socket sends and gets.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstring>

#include "hil/usbip/cable.hpp"
#include "hil/usbip/exported_device.hpp"
#include "hil/usbip/server.hpp"
#include "hil/usbip/wire.hpp"
#include "tests/unit/usb/usb_bench.hpp"

namespace umov::test {
namespace {

using namespace usbip;

struct Reply {
  std::uint32_t command = 0;
  std::uint32_t number = 0;
  std::int32_t status = 0;
  std::uint32_t length = 0;
  Bytes data;
};

/// The kernel's end of a cable.
class Kernel {
 public:
  explicit Kernel(int descriptor) : socket_(descriptor) {}

  void submit(std::uint32_t number, std::uint32_t endpoint, bool to_host, std::uint32_t length,
              const Bytes& data = {}, const std::array<std::uint8_t, 8>& setup = {}) {
    Bytes out;
    wire::Writer(out)
        .u32(wire::command_submit)
        .u32(number)
        .u32(0x10002)
        .u32(to_host ? 1 : 0)
        .u32(endpoint)
        .u32(0)
        .u32(length)
        .u32(0)
        .u32(0xffffffffu)
        .u32(0)
        .bytes(setup)
        .bytes(data);
    send_raw(out);
  }
  void unlink(std::uint32_t number, std::uint32_t which) {
    Bytes out;
    wire::Writer(out).u32(wire::command_unlink).u32(number).u32(0x10002).u32(0).u32(0).u32(which);
    out.resize(wire::header_bytes);
    send_raw(out);
  }
  void send_raw(const Bytes& bytes) {
    ASSERT_EQ(::send(socket_.descriptor(), bytes.data(), bytes.size(), 0),
              static_cast<ssize_t>(bytes.size()));
  }
  /// What has arrived; data follows replies to `reads`.
  std::vector<Reply> replies(const std::vector<std::uint32_t>& reads) {
    std::array<std::uint8_t, 65536> buffer;
    const ssize_t count = ::recv(socket_.descriptor(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    std::vector<Reply> found;
    const Bytes bytes(buffer.begin(), buffer.begin() + std::max<ssize_t>(count, 0));
    for (std::size_t at = 0; at + wire::header_bytes <= bytes.size();) {
      Reply reply;
      reply.command = wire::u32_at(bytes, at);
      reply.number = wire::u32_at(bytes, at + 4);
      reply.status = static_cast<std::int32_t>(wire::u32_at(bytes, at + 20));
      if (reply.command == wire::return_submit) reply.length = wire::u32_at(bytes, at + 24);
      at += wire::header_bytes;
      if (std::find(reads.begin(), reads.end(), reply.number) != reads.end()) {
        reply.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                          bytes.begin() + static_cast<std::ptrdiff_t>(at + reply.length));
        at += reply.length;
      }
      found.push_back(reply);
    }
    return found;
  }

 private:
  net::Socket socket_;
};

class UsbCable : public ::testing::Test {
 protected:
  UsbCable() {
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
    kernel.emplace(ends[0]);
    cable.emplace(net::Socket(ends[1]), bench.port);
    kernel->submit(1, 0, false, 0, {}, {0x00, 9, 1, 0, 0, 0, 0, 0});
    cable->service();
    EXPECT_EQ(kernel->replies({}).at(0).status, 0);
    EXPECT_TRUE(bench.device.configured());
  }
  UsbBench bench;
  std::array<int, 2> ends{};
  std::optional<Kernel> kernel;
  std::optional<Cable> cable;
};

TEST_F(UsbCable, a_descriptor_is_read_and_a_refusal_told) {
  kernel->submit(2, 0, true, 64, {}, {0x80, 6, 0, 1, 0, 0, 64, 0});
  kernel->submit(3, 0, true, 10, {}, {0x80, 6, 0, 6, 0, 0, 10, 0});
  cable->service();
  const auto replies = kernel->replies({2, 3});
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0].number, 2u);
  EXPECT_EQ(replies[0].data.size(), 18u);
  EXPECT_EQ(replies[1].status, urb_status::stalled);
  EXPECT_EQ(replies[1].length, 0u);
}

TEST_F(UsbCable, a_read_waits_until_the_device_has_something_to_say) {
  kernel->submit(2, 1, true, 4096);
  kernel->submit(3, 1, true, 4096);
  cable->service();
  EXPECT_TRUE(kernel->replies({2, 3}).empty());
  kernel->submit(4, 1, false, 50, [] {
    Bytes hello = hello_frame("kernel");
    hello.resize(50);
    return hello;
  }());
  cable->service();
  bench.device.write_link(counting_bytes(100));
  cable->service();
  auto replies = kernel->replies({2, 3});
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0].number, 4u);
  EXPECT_EQ(replies[0].length, 50u);
  EXPECT_EQ(replies[1].number, 2u);
  EXPECT_EQ(replies[1].data, counting_bytes(100));
  bench.device.write_link(counting_bytes(64));
  cable->service();
  replies = kernel->replies({3});
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].data, counting_bytes(64)) << "ended by an empty packet";
}

TEST_F(UsbCable, a_read_taken_back_does_not_end_twice) {
  kernel->submit(2, 1, true, 4096);
  cable->service();
  kernel->unlink(3, 2);
  kernel->unlink(4, 99);
  cable->service();
  const auto replies = kernel->replies({});
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0].command, wire::return_unlink);
  EXPECT_EQ(replies[0].status, urb_status::unlinked);
  EXPECT_EQ(replies[1].status, 0) << "had ended before";
}

TEST_F(UsbCable, commands_may_come_in_pieces) {
  Bytes out;
  wire::Writer(out)
      .u32(wire::command_submit)
      .u32(2)
      .u32(0)
      .u32(0)
      .u32(1)
      .u32(0)
      .u32(3)
      .u32(0)
      .u32(0xffffffffu);
  out.resize(wire::header_bytes);
  out.insert(out.end(), {1, 2, 3});
  for (const std::uint8_t byte : out) {
    EXPECT_TRUE(kernel->replies({}).empty());
    kernel->send_raw({byte});
    cable->service();
  }
  EXPECT_EQ(kernel->replies({}).at(0).length, 3u);
}

TEST_F(UsbCable, nonsense_and_a_closed_socket_end_it) {
  Bytes nonsense(48, 0xff);
  kernel->send_raw(nonsense);
  cable->service();
  EXPECT_TRUE(cable->broken());
  EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  cable.emplace(net::Socket(ends[1]), bench.port);
  EXPECT_FALSE(bench.device.configured()) << "plugged in anew";
  cable->service();
  EXPECT_FALSE(cable->broken());
  ::close(ends[0]);
  cable->service();
  EXPECT_TRUE(cable->broken());
}

/// A client of the server's import phase.
class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(
        ::connect(socket_.descriptor(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  Bytes ask(Server& server, std::uint16_t code, const std::string& bus_id = {}) {
    Bytes out;
    wire::Writer(out).u16(wire::version).u16(code).u32(0);
    if (!bus_id.empty()) wire::Writer(out).text(bus_id, wire::bus_id_bytes);
    EXPECT_EQ(::send(socket_.descriptor(), out.data(), out.size(), 0),
              static_cast<ssize_t>(out.size()));
    for (int i = 0; i < 50; ++i) {
      server.wait(std::chrono::milliseconds(20));
      server.service();
      std::array<std::uint8_t, 4096> buffer;
      const ssize_t count =
          ::recv(socket_.descriptor(), buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (count > 0) return {buffer.begin(), buffer.begin() + count};
    }
    return {};
  }

 private:
  net::Socket socket_;
};

TEST(UsbServer, lists_its_devices_and_gives_each_to_one_host) {
  UsbBench bench;
  std::vector<std::string> events;
  Server server({export_device("1-1", 2, bench.port)}, [&](const std::string& id, bool plugged) {
    events.push_back(id + (plugged ? "+" : "-"));
  });
  const std::uint16_t port = server.listen(0);
  const Bytes list = Client(port).ask(server, wire::request_list);
  ASSERT_EQ(list.size(), 8u + 4 + 312 + 4 * 4);
  EXPECT_EQ(wire::u16_at(list, 2), wire::reply_list);
  EXPECT_EQ(wire::u32_at(list, 8), 1u);
  EXPECT_STREQ(reinterpret_cast<const char*>(&list.at(12 + 256)), "1-1");
  EXPECT_EQ(wire::u16_at(list, 12 + 300), 0x1209);
  EXPECT_EQ(list.at(12 + 312), 0xff) << "class of the first interface";

  EXPECT_EQ(wire::u32_at(Client(port).ask(server, wire::request_import, "7-7"), 4), 1u);
  {
    Client first(port);
    const Bytes reply = first.ask(server, wire::request_import, "1-1");
    ASSERT_EQ(reply.size(), 8u + 312);
    EXPECT_EQ(wire::u32_at(reply, 4), 0u);
    EXPECT_TRUE(server.plugged("1-1"));
    EXPECT_EQ(wire::u32_at(Client(port).ask(server, wire::request_import, "1-1"), 4), 1u)
        << "somebody else has it";
  }
  server.wait(std::chrono::milliseconds(20));
  server.service();
  EXPECT_FALSE(server.plugged("1-1"));
  EXPECT_THAT(events, ::testing::ElementsAre("1-1+", "1-1-"));
  Client second(port);
  EXPECT_EQ(wire::u32_at(second.ask(server, wire::request_import, "1-1"), 4), 0u);
}

TEST(UsbServer, clients_that_never_ask_keep_nobody_out) {
  UsbBench bench;
  Server server({export_device("1-1", 2, bench.port)});
  const std::uint16_t port = server.listen(0);
  std::vector<std::unique_ptr<Client>> silent;
  for (int i = 0; i < 40; ++i) {
    silent.push_back(std::make_unique<Client>(port));
    server.service();
  }
  EXPECT_EQ(Client(port).ask(server, wire::request_list).size(), 8u + 4 + 312 + 4 * 4);
}

}  // namespace
}  // namespace umov::test
