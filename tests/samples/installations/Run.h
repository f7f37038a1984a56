#pragma once

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

/// A folder of a test's own, empty at first and gone with it.
class OwnFolder
{
public:
    explicit OwnFolder(const std::string& name) :
        path((std::filesystem::temp_directory_path() /
              ("midair_" + name + "_" + std::to_string(::getpid())))
                 .string())
    {
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~OwnFolder() { std::filesystem::remove_all(path); }
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;

    const std::string path;
};

/// What an installation did, run headless.
struct Visit // NOLINT(bugprone-exception-escape): moving JSON asserts, and throws nothing
{
    Outcome outcome;
    nlohmann::json report;
};

/// Runs midair-NAME without pictures, with its report in \a out.
inline Visit visit(const std::string& name, const std::string& arguments, const OwnFolder& out)
{
    Visit made;
    made.outcome = shell(std::string("'") + MIDAIR_BIN + "/midair-" + name +
                         "' --headless --pictures 0 --out '" + out.path + "' " + arguments);
    std::ifstream file(out.path + "/report.json");
    if (file) made.report = nlohmann::json::parse(file, nullptr, false);
    return made;
}

/// What no installation may do: sound where it must be silent, say a thing over and over, lose or
/// be refused fields.
inline void expectQuiet(const nlohmann::json& report)
{
    EXPECT_EQ(report.at("silence").at("playedMuted"), 0);
    EXPECT_EQ(report.at("silence").at("playedAlone"), 0);
    EXPECT_TRUE(report.at("tooOften").empty()) << report.at("tooOften");
    EXPECT_EQ(report.at("fields").at("lost"), 0);
    EXPECT_EQ(report.at("fields").at("refused"), 0);
    EXPECT_EQ(report.at("fields").at("faults"), 0);
    // The visitor's hand moves as one does; a jump within a frame is faster.
    EXPECT_LT(report.value("visitor_m_s", 0.0), 1.0);
    for (const auto& message : report.at("messages"))
        EXPECT_LT(message.at("severity"), 2) << message;
}
