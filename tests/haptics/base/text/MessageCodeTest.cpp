// The table of codes, and the document that users have of it.
#include "haptics/base/text/MessageLog.h"

#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::base;

TEST(MessageCode, HasOneRowEachInTheirOrder)
{
    const std::vector<MessageKind>& kinds = messageKinds();
    const std::regex pattern("[a-z]+\\.[a-z]+");
    std::set<std::string> names;
    for (std::size_t i = 0; i < kinds.size(); ++i)
    {
        EXPECT_EQ(static_cast<std::size_t>(kinds[i].code), i) << kinds[i].name;
        EXPECT_TRUE(std::regex_match(kinds[i].name, pattern)) << kinds[i].name;
        EXPECT_TRUE(names.insert(kinds[i].name).second) << kinds[i].name << " is there twice";
        EXPECT_STREQ(kindOf(kinds[i].code).name, kinds[i].name);
    }
    EXPECT_EQ(kinds.back().code, MessageCode::VIEWER_SILENT) << "the last of the codes has a row";
}

TEST(MessageCode, IsInTheDocument)
{
    std::ifstream document(MIDAIR_ROOT "/samples/guides/MESSAGES.md");
    ASSERT_TRUE(document) << "samples/guides/MESSAGES.md";
    const std::regex row(R"(\| `([^`]+)` \| (\w+) \| ([^|]+) \| ([^|]+) \|)");
    std::vector<std::string> said;
    for (std::string line; std::getline(document, line);)
    {
        std::smatch match;
        if (line.rfind("| `", 0) != 0) continue;
        EXPECT_TRUE(std::regex_match(line, match, row))
            << "a row has a code, a severity, what it means and what to do: " << line;
        said.push_back(match[1].str() + " " + match[2].str());
    }
    std::vector<std::string> wanted;
    for (const MessageKind& kind : messageKinds())
        wanted.push_back(std::string(kind.name) + " " + severityName(kind.severity));
    EXPECT_EQ(said, wanted);
}
