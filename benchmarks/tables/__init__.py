# SPDX-License-Identifier: Apache-2.0
"""What reads result files and makes Markdown of them: one module for each group of tables."""
