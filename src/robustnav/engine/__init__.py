"""The filters at C speed."""
