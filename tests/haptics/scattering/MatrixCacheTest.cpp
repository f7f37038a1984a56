#include "haptics/scattering/MatrixCache.h"

#include "haptics/scattering/RigidBody.h"
#include "tests/haptics/scattering/Scattered.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

using namespace midair;
using midair::test::ballOf;
using midair::test::kWavelength_m;

namespace
{

namespace fs = std::filesystem;

class KeptBody : public testing::Test
{
protected:
    KeptBody() : _folder(fs::path(testing::TempDir()) / "midair-kept-bodies")
    {
        fs::remove_all(_folder);
        _making.cache.folder = _folder;
        _making.cache.leastMaking_s = 0.0;
        _making.cache.told = [this](const std::string& what) { _told += what + "\n"; };
        _making.progress = [this](double share) { _made = share; };
    }
    ~KeptBody() override { fs::remove_all(_folder); }

    /// The pressures on a ball; sets made() and told().
    Eigen::VectorXcd pressures(double radius_m = 4e-3)
    {
        _made = 0.0;
        _told.clear();
        const haptics::RigidBody ball(
            haptics::RigidBody::divided(ballOf(radius_m, 2e-3), kWavelength_m),
            kWavelength_m,
            _making);
        Eigen::VectorXcd onBall;
        ball.solve(test::fieldOf({0.0, 0.0, 0.05}, 732.0, ball), onBall);
        return onBall;
    }
    bool isMade() const { return _made == 1.0; }
    bool isTold(const std::string& what) const { return _told.find(what) != std::string::npos; }
    std::vector<fs::path> files() const
    {
        std::vector<fs::path> all;
        for (const auto& entry : fs::directory_iterator(_folder))
            all.push_back(entry.path());
        return all;
    }

    fs::path _folder;
    haptics::BodyMaking _making;
    std::string _told;
    double _made = 0.0;
};

} // namespace

TEST_F(KeptBody, IsReadAsItWasMade)
{
    const Eigen::VectorXcd made = pressures();
    EXPECT_TRUE(isMade());
    EXPECT_TRUE(isTold("kept as ")) << _told;
    ASSERT_EQ(files().size(), 1U);
    const Eigen::VectorXcd read = pressures();
    EXPECT_FALSE(isMade());
    EXPECT_TRUE(isTold("read from ")) << _told;
    EXPECT_EQ(read, made);
    pressures(4.1e-3);
    EXPECT_TRUE(isMade()) << "another body";
    EXPECT_EQ(files().size(), 2U);
    _making.cache.folder.clear();
    pressures();
    EXPECT_TRUE(isMade());
    EXPECT_EQ(_told, "");
}

TEST_F(KeptBody, IsNotKeptIfItIsMadeSoon)
{
    _making.cache.leastMaking_s = 100.0;
    pressures();
    EXPECT_FALSE(fs::exists(_folder));
}

TEST_F(KeptBody, BrokenFilesAreMadeAnewAndTold)
{
    const Eigen::VectorXcd made = pressures();
    const fs::path file = files().front();
    const auto size = fs::file_size(file);
    const auto expectMade = [&](const std::string& why)
    {
        EXPECT_EQ(pressures(), made) << why;
        EXPECT_TRUE(isMade()) << why;
        EXPECT_TRUE(isTold("is not used: " + why)) << _told;
        EXPECT_TRUE(isTold("kept as ")) << _told;
    };
    const auto overwrite = [&](std::streamoff at, char value)
    {
        std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
        stream.seekp(at);
        stream.put(value);
    };
    fs::resize_file(file, size - 1);
    expectMade("it has ");
    fs::resize_file(file, size + 8);
    expectMade("it has ");
    fs::resize_file(file, 0);
    expectMade("it has ");
    overwrite(0, 'x');
    expectMade("its head is another's");
    overwrite(16, 'x'); // the size it says
    expectMade("its head is another's");
    overwrite(static_cast<std::streamoff>(size) - 5, 'x');
    expectMade("its checksum is wrong");
    fs::remove(file);
    fs::create_directory(file);
    pressures();
    EXPECT_TRUE(isMade());
    EXPECT_TRUE(isTold("it is no file")) << _told;
    EXPECT_TRUE(isTold("can't be written")) << _told;
    fs::remove(file);
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
    pressures(); // and doesn't wait for somebody who writes
    EXPECT_TRUE(isTold("it is no file")) << _told;
}

TEST_F(KeptBody, LeavesOnlyWhatWasUsedLast)
{
    pressures(4e-3);
    const fs::path first = files().front();
    const auto bytes = static_cast<double>(fs::file_size(first));
    fs::last_write_time(first, fs::file_time_type::clock::now() - std::chrono::hours(2));
    std::ofstream(_folder / "1.body.99.part") << "unfinished";
    fs::last_write_time(_folder / "1.body.99.part",
                        fs::file_time_type::clock::now() - std::chrono::hours(2));
    std::ofstream(_folder / "another.txt") << "of somebody else";
    _making.cache.mostBytes = 2.5 * bytes;
    pressures(4.01e-3);
    EXPECT_TRUE(fs::exists(first));
    EXPECT_FALSE(fs::exists(_folder / "1.body.99.part"));
    _making.cache.mostBytes = 1.5 * bytes;
    pressures(4.02e-3);
    EXPECT_FALSE(fs::exists(first));
    EXPECT_TRUE(isTold("is removed")) << _told;
    EXPECT_EQ(files().size(), 2U) << "and the other text";
    EXPECT_TRUE(fs::exists(_folder / "another.txt"));
    _making.cache.mostBytes = 0.5 * bytes;
    pressures(4.03e-3);
    EXPECT_TRUE(isMade());
    EXPECT_EQ(files().size(), 2U) << "a body over the limit is not kept at all";
}
