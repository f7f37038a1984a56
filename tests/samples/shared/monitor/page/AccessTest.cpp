// Who may look and who may act: addresses, Host headers, tokens.
#include "samples/shared/monitor/page/MonitorAccess.h"

#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::samples;

namespace
{

std::string errorOf(const std::string& address)
{
    try
    {
        MonitorAddress::parse(address);
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "none";
}

/// A folder for the token's file.
class TokenFolder : public testing::Test
{
protected:
    TokenFolder() { std::filesystem::create_directories(_folder); }
    ~TokenFolder() override { std::filesystem::remove_all(_folder); }

    std::string write(const std::string& name, const std::string& text, mode_t mode)
    {
        std::string path = (_folder / name).string();
        std::ofstream(path) << text;
        ::chmod(path.c_str(), mode);
        return path;
    }
    static std::string problemOf(const std::string& path)
    {
        try
        {
            tokenOfFile(path);
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return "none";
    }

    const std::filesystem::path _folder =
        std::filesystem::temp_directory_path() / ("midair_token" + std::to_string(::getpid()));
};

} // namespace

TEST(MonitorAddress, IsLoopbackUnlessAnotherIsNamed)
{
    EXPECT_EQ(MonitorAddress::parse(":8080").text(), "127.0.0.1:8080");
    EXPECT_EQ(MonitorAddress::parse("localhost:1").text(), "127.0.0.1:1");
    EXPECT_EQ(MonitorAddress::parse("[::1]:8080").text(), "[::1]:8080");
    EXPECT_EQ(MonitorAddress::parse("0.0.0.0:65535").text(), "0.0.0.0:65535");
    for (const char* own : {":8080", "127.0.0.2:1", "[::1]:1"})
        EXPECT_TRUE(MonitorAddress::parse(own).isLoopback()) << own;
    for (const char* open : {"0.0.0.0:1", "192.168.1.2:1", "[::]:1", "[fe80::1]:1"})
        EXPECT_FALSE(MonitorAddress::parse(open).isLoopback()) << open;
}

TEST(MonitorAddress, SaysWhatIsWrong)
{
    EXPECT_EQ(errorOf("8080").find("is \"8080\", should be ADDRESS:PORT"), 0U);
    for (const char* wrong : {"",
                              "127.0.0.1",
                              "127.0.0.1:",
                              "127.0.0.1:65536",
                              "127.0.0.1:-1",
                              "127.0.0.1:80x",
                              "127.0.0.1: 80",
                              "127.0.0.1:99999999999999999999",
                              "127.0.0:80",
                              "example.org:80",
                              "::1:80",
                              "[::1]80",
                              "[::1",
                              "[]:80",
                              "[127.0.0.1]:80"})
        EXPECT_NE(errorOf(wrong), "none") << wrong;
}

TEST(MonitorAddress, TrustsNoNameThatAStrangerCanMakeLeadHere)
{
    const std::vector<std::string> names = {"Gallery-PC"};
    for (const char* good : {"127.0.0.1",
                             "127.0.0.1:8080",
                             "10.1.2.3:1",
                             "[::1]:8080",
                             "[2001:db8::1]",
                             "localhost",
                             "LOCALHOST:9",
                             "gallery-pc:8080"})
        EXPECT_TRUE(isTrustedHost(good, names)) << good;
    for (const std::string& bad : {std::string(""),
                                   std::string("evil.example:8080"),
                                   std::string("localhost.evil.example"),
                                   std::string("127.0.0.1.evil.example"),
                                   std::string("evil.example:127.0.0.1"),
                                   std::string("127.0.0.1:8080:1"),
                                   std::string("127.0.0.1:x"),
                                   std::string("[::1"),
                                   std::string("[evil.example]"),
                                   std::string("[::1]evil.example"),
                                   std::string("127.1"),
                                   std::string("0x7f000001"),
                                   std::string("localhost@evil.example"),
                                   std::string("127.0.0.1\0.evil.example", 23)})
        EXPECT_FALSE(isTrustedHost(bad, names)) << bad;
}

TEST(MonitorToken, IsNewEachTimeAndComparedWhole)
{
    std::set<std::string> tokens;
    for (int i = 0; i < 100; ++i)
        tokens.insert(newToken());
    EXPECT_EQ(tokens.size(), 100U);
    EXPECT_EQ(tokens.begin()->size(), 32U);
    const std::string token = *tokens.begin();
    EXPECT_TRUE(isSameToken(token, token));
    EXPECT_FALSE(isSameToken(token + "0", token));
    EXPECT_FALSE(isSameToken(token.substr(0, 31), token));
    EXPECT_FALSE(isSameToken("", token));
    EXPECT_FALSE(isSameToken("", ""));
    for (std::size_t i = 0; i < token.size(); ++i)
    {
        std::string other = token;
        other[i] = other[i] == 'a' ? 'b' : 'a';
        EXPECT_FALSE(isSameToken(other, token)) << i;
    }
}

TEST_F(TokenFolder, MakesAFileForItsOwnerAloneAndKeepsIt)
{
    const std::string path = (_folder / "new").string();
    const std::string token = tokenOfFile(path);
    EXPECT_EQ(token.size(), 32U);
    struct stat about = {};
    ASSERT_EQ(::stat(path.c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0600U);
    EXPECT_EQ(tokenOfFile(path), token);
}

TEST_F(TokenFolder, RefusesWhatIsNoSecret)
{
    EXPECT_EQ(tokenOfFile(write("good", "abcdefghijklmnop\nanything\n", 0600)), "abcdefghijklmnop");
    const std::string open = write("open", "abcdefghijklmnop\n", 0644);
    EXPECT_NE(problemOf(open).find("chmod 600 " + open), std::string::npos) << problemOf(open);
    for (const std::string& text : {std::string("short\n"),
                                    std::string("\n"),
                                    std::string(),
                                    std::string("abcdefgh ijklmnop\n"),
                                    std::string("abcdefghijklmnop\r\n"),
                                    std::string(300, 'a')})
    {
        const std::string path = write("bad", text, 0600);
        EXPECT_EQ(problemOf(path).find("the token's file " + path), 0U) << text;
        EXPECT_NE(problemOf(path).find("16 to 256 letters"), std::string::npos) << text;
    }
    EXPECT_NE(problemOf(_folder.string()), "none");
    EXPECT_EQ(problemOf("/nowhere/token"),
              "the token's file /nowhere/token can't be created: No such file or directory");
}
